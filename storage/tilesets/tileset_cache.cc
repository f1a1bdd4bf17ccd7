#include "storage/tilesets/tileset_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/try.h"

namespace skyquilt::storage {

namespace {

Result<Tileset> OpenTileset(const std::string& flight_id, const Revision& revision,
                            const std::filesystem::path& folder) {
  Tileset tileset{flight_id, revision, nullptr, {}};
  for (const render::MapLayer layer : render::kMapLayers) {
    Result<std::shared_ptr<MbtilesReader>> reader =
        MbtilesReader::Open(folder / render::LayerFileName(layer));
    if (reader) {
      tileset.layers[layer] = *std::move(reader);
    } else if (reader.error().code != ErrorCode::kNotFound) {
      return reader.error();
    }
  }
  // The map last: its absence says that the folder is gone, and the layers need not be opened.
  SKYQUILT_TRY_ASSIGN(std::shared_ptr<MbtilesReader> reader, MbtilesReader::Open(folder / "mosaic.mbtiles"));
  tileset.reader = std::move(reader);
  return tileset;
}

}  // namespace

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
  // Only a revision retired twice within one request can vanish between the query and the opening.
  constexpr int kTries = 3;
  for (int attempt = 1;; ++attempt) {
    const auto read_at = std::chrono::steady_clock::now();
    SKYQUILT_TRY_ASSIGN(const std::optional<Revision> revision, catalogue_.ActiveRevision(flight_id));
    if (!revision) {
      Forget(flight_id);
      return Error{ErrorCode::kNotFound, fmt::format("Flight {} has no map (yet).", flight_id), ""};
    }
    {
      const std::lock_guard lock(mutex_);
      const auto found = entries_.find(flight_id);
      if (found != entries_.end() && found->second.tileset->revision.revision >= revision->revision) {
        found->second.checked = found->second.used = read_at;
        return found->second.tileset;
      }
    }
    Result<Tileset> opened = OpenTileset(flight_id, *revision, dir_.Revision(flight_id, revision->revision));
    if (!opened) {
      if (opened.error().code == ErrorCode::kNotFound && attempt < kTries) continue;
      return opened.error();
    }
    auto tileset = std::make_shared<const Tileset>(*std::move(opened));
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[flight_id];
    // Two threads may have opened different revisions; a flight never goes back.
    if (entry.tileset == nullptr || entry.tileset->revision.revision < tileset->revision.revision) {
      entry.tileset = std::move(tileset);
    }
    entry.checked = entry.used = read_at;
    std::shared_ptr<const Tileset> answer = entry.tileset;
    if (entries_.size() > kMaxOpen) DropLeastUsed();
    return answer;
  }
}

bool TilesetCache::IsOpen(const std::string& flight_id) const {
  const std::lock_guard lock(mutex_);
  return entries_.contains(flight_id);
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
