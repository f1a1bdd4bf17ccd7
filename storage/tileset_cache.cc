#include "storage/tileset_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace skyquilt::storage {

Result<std::shared_ptr<const Tileset>> TilesetCache::Get(const std::string& flight_id) {
  const auto now = std::chrono::steady_clock::now();
  {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(flight_id);
    if (found != entries_.end() && now - found->second.checked < kFreshFor) {
      found->second.used = now;
      return found->second.tileset;
    }
  }
  return Refresh(flight_id);
}

Result<std::shared_ptr<const Tileset>> TilesetCache::Refresh(const std::string& flight_id) {
  // Only a revision retired twice within one request can vanish between the look and the opening.
  constexpr int kTries = 3;
  for (int attempt = 1;; ++attempt) {
    const auto asked = std::chrono::steady_clock::now();
    const Result<std::optional<Revision>> revision = catalogue_.ActiveRevision(flight_id);
    if (!revision) return revision.error();
    if (!*revision) {
      Forget(flight_id);
      return Error{ErrorCode::kNotFound, fmt::format("Flight {} has no map (yet).", flight_id), ""};
    }
    {
      const std::lock_guard lock(mutex_);
      const auto found = entries_.find(flight_id);
      if (found != entries_.end() && found->second.tileset->revision.revision >= (*revision)->revision) {
        found->second.checked = found->second.used = asked;
        return found->second.tileset;
      }
    }
    const auto path = dir_.Revision(flight_id, (*revision)->revision) / "mosaic.mbtiles";
    Result<std::shared_ptr<MbtilesReader>> reader = MbtilesReader::Open(path);
    if (!reader) {
      if (reader.error().code == ErrorCode::kNotFound && attempt < kTries) continue;
      return reader.error();
    }
    auto tileset = std::make_shared<const Tileset>(Tileset{flight_id, **revision, *std::move(reader)});
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[flight_id];
    // Two threads may have opened different revisions; a flight never goes back.
    if (entry.tileset == nullptr || entry.tileset->revision.revision < tileset->revision.revision) {
      entry.tileset = std::move(tileset);
    }
    entry.checked = entry.used = asked;
    std::shared_ptr<const Tileset> answer = entry.tileset;
    if (entries_.size() > kMaxOpen) DropLeastUsed();
    return answer;
  }
}

void TilesetCache::Forget(const std::string& flight_id) {
  const std::lock_guard lock(mutex_);
  entries_.erase(flight_id);
}

void TilesetCache::DropLeastUsed() {
  const auto oldest = std::min_element(entries_.begin(), entries_.end(), [](const auto& a, const auto& b) {
    return a.second.used < b.second.used;
  });
  entries_.erase(oldest);
}

}  // namespace skyquilt::storage
