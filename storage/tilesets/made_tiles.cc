#include "storage/tilesets/made_tiles.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <utility>

namespace skyquilt::storage {
namespace {

// Beside a tile's bytes: its key, twice, and its places in the list and the map, about.
constexpr std::size_t kBesideBytes = 400;

std::size_t CostOf(const MadeTile& tile) { return tile.bytes.size() + kBesideBytes; }

}  // namespace

std::string MadeTileKey::Text() const {
  return fmt::format("{}/{}/{}/{}/{}/{}/{}/{}/{}/{}/{}", flight_id, revision, tile.z(), tile.x(), tile.y(),
                     static_cast<int>(format), scale, cut_px, whole_px, look, grid);
}

// Whoever makes a tile says so at its end, however that comes, and those who wait go on.
class MadeTiles::Maker {
 public:
  Maker(MadeTiles& owner, std::string key) : owner_(owner), key_(std::move(key)) {}
  ~Maker() {
    const std::lock_guard lock(owner_.mutex_);
    const auto found = owner_.making_.find(key_);
    found->second->is_done = true;
    owner_.making_.erase(found);
    owner_.made_.notify_all();
  }
  Maker(const Maker&) = delete;
  Maker& operator=(const Maker&) = delete;

 private:
  MadeTiles& owner_;
  std::string key_;
};

std::shared_ptr<const MadeTile> MadeTiles::Touch(const std::string& key) {
  const auto place = places_.find(key);
  if (place == places_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, place->second);
  return place->second->tile;
}

void MadeTiles::Keep(const std::string& key, std::shared_ptr<const MadeTile> tile) {
  if (CostOf(*tile) > budget_bytes_) return;
  bytes_ += CostOf(*tile);
  entries_.push_front({key, std::move(tile)});
  places_[key] = entries_.begin();
  while (bytes_ > budget_bytes_) {
    bytes_ -= CostOf(*entries_.back().tile);
    places_.erase(entries_.back().key);
    entries_.pop_back();
  }
}

std::shared_ptr<const MadeTile> MadeTiles::Find(const MadeTileKey& key) {
  const std::string text = key.Text();
  const std::lock_guard lock(mutex_);
  return Touch(text);
}

Result<std::shared_ptr<const MadeTile>> MadeTiles::Get(const MadeTileKey& key,
                                                       const std::function<Result<std::string>()>& make) {
  const std::string text = key.Text();
  std::shared_ptr<Making> making;
  {
    std::unique_lock lock(mutex_);
    while (true) {
      if (std::shared_ptr<const MadeTile> tile = Touch(text)) return tile;
      const auto found = making_.find(text);
      if (found == making_.end()) break;
      const std::shared_ptr<Making> others = found->second;
      made_.wait(lock, [&] { return others->is_done; });
      // Nothing in it: its maker ran out of something, which need not happen to this one.
      if (!others->outcome || *others->outcome != nullptr) return others->outcome;
    }
    making = making_[text] = std::make_shared<Making>();
  }
  const Maker maker(*this, text);
  Result<std::string> bytes = make();
  Result<std::shared_ptr<const MadeTile>> outcome = std::shared_ptr<const MadeTile>();
  if (bytes) {
    const std::uint64_t digest = XXH3_64bits(bytes->data(), bytes->size());
    outcome = std::make_shared<const MadeTile>(MadeTile{*std::move(bytes), digest});
  } else {
    outcome = bytes.error();
  }
  const std::lock_guard lock(mutex_);
  making->outcome = outcome;
  if (outcome) Keep(text, *outcome);
  return outcome;
}

MadeTiles::Kept MadeTiles::kept() const {
  const std::lock_guard lock(mutex_);
  return {entries_.size(), bytes_};
}

}  // namespace skyquilt::storage
