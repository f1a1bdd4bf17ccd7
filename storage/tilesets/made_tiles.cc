#include "storage/tilesets/made_tiles.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <utility>

namespace skyquilt::storage {
namespace {

// Beside a tile's bytes: its key, twice, and its places in the list and the map, about.
constexpr std::size_t kBesideBytes = 400;

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

Result<std::shared_ptr<const MadeTile>> MadeTiles::Get(const MadeTileKey& key,
                                                       const std::function<Result<std::string>()>& make) {
  const std::string text = key.Text();
  std::shared_ptr<Making> making;
  {
    std::unique_lock lock(mutex_);
    while (true) {
      if (std::shared_ptr<const MadeTile> tile = tiles_.Find(text)) return tile;
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
  if (outcome) {
    // One that is larger than all of the budget is given, not kept.
    const std::size_t cost = (*outcome)->bytes.size() + kBesideBytes;
    if (cost <= tiles_.budget_bytes()) tiles_.Keep(text, *outcome, cost);
  }
  return outcome;
}

}  // namespace skyquilt::storage
