#include "storage/caches/tileset_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/try.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {

namespace {

// A file in the cache.
Result<std::shared_ptr<MapTiles>> OpenFetched(BlobStore& blobs, const std::string& key) {
  Result<LocalBlob> file = blobs.Local(key);
  // The store has another file: that is no fault of the map's, and may be mended there.
  if (!file && file.error().code == ErrorCode::kCorrupt)
    return Error{ErrorCode::kUnavailable, file.error().message, file.error().detail};
  if (!file) return file.error();
  SKYQUILT_TRY_ASSIGN(std::shared_ptr<MbtilesReader> reader, MbtilesReader::Open(file->path));
  return std::shared_ptr<MapTiles>(KeepingFile(std::move(reader), *file));
}

// In the data folder.
Result<Tileset> OpenHere(const std::string& flight_id, const Revision& revision,
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
  SKYQUILT_TRY_ASSIGN(tileset.reader, MbtilesReader::Open(folder / "mosaic.mbtiles"));
  return tileset;
}

// The map by ranges; layers are small and come whole.
Result<Tileset> OpenInObjectStore(const std::string& flight_id, const Revision& revision,
                                  const std::shared_ptr<BlobStore>& blobs,
                                  const std::shared_ptr<PmtilesMemory>& memory) {
  const std::string prefix = RevisionPrefix(flight_id, revision.revision);
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> products, blobs->List(prefix));
  const auto has = [&](const std::string& name) {
    return std::any_of(products.begin(), products.end(),
                       [&](const BlobInfo& product) { return product.key == prefix + name; });
  };
  Tileset tileset{flight_id, revision, nullptr, {}};
  for (const render::MapLayer layer : render::kMapLayers) {
    if (!has(render::LayerFileName(layer))) continue;
    SKYQUILT_TRY_ASSIGN(tileset.layers[layer], OpenFetched(*blobs, prefix + render::LayerFileName(layer)));
  }
  if (has("mosaic.pmtiles")) {
    SKYQUILT_TRY_ASSIGN(tileset.reader, PmtilesReader::Open(blobs, prefix + "mosaic.pmtiles", memory));
  } else {
    SKYQUILT_TRY_ASSIGN(tileset.reader, OpenFetched(*blobs, prefix + "mosaic.mbtiles"));
  }
  return tileset;
}

}  // namespace

TilesetCache::TilesetCache(DataDir dir, Catalogue& catalogue, std::shared_ptr<BlobStore> blobs,
                           bool is_shared)
    : dir_(std::move(dir)),
      catalogue_(catalogue),
      blobs_(blobs == nullptr || blobs->IsFolder() ? nullptr : std::move(blobs)),
      is_shared_(is_shared) {}

Result<std::shared_ptr<const Tileset>> TilesetCache::Get(const std::string& flight_id) {
  const auto now = std::chrono::steady_clock::now();
  std::shared_ptr<const Tileset> shown;
  {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(flight_id);
    if (found != entries_.end()) {
      shown = found->second.tileset;
      if (now - found->second.checked < kFreshFor) {
        found->second.used = now;
        return shown;
      }
    }
  }
  if (!is_shared_ || shown == nullptr) return Refresh(flight_id);
  // The catalogue alone is read there, for all flights by one thread: a store that is slow with the map of
  // one holds up no other.
  const Result<void> read = again_.Ask(flight_id, Looking(flight_id));
  if (!read && read.error().code == ErrorCode::kUnavailable) return shown;
  if (!read) return read.error();
  const auto mine = std::make_shared<int>();
  {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(flight_id);
    if (found == entries_.end()) return shown;
    Entry& entry = found->second;
    if (entry.newest <= entry.tileset->revision.revision || !entry.opening.expired()) return entry.tileset;
    entry.opening = mine;
  }
  Result<std::shared_ptr<const Tileset>> opened = Refresh(flight_id);
  if (!opened && opened.error().code == ErrorCode::kUnavailable) {
    // The next try after the same while: not each request waits for the store.
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(flight_id);
    if (found != entries_.end()) found->second.checked = std::chrono::steady_clock::now();
    return shown;
  }
  return opened;
}

Result<void> TilesetCache::CheckCatalogue() const {
  const auto read = [this]() -> Result<void> {
    SKYQUILT_TRY(catalogue_.HasFlight(""));
    return {};
  };
  return is_shared_ ? looks_.Ask("catalogue", read) : read();
}

Result<Revision> TilesetCache::Look(const std::string& flight_id) {
  const auto read_at = std::chrono::steady_clock::now();
  SKYQUILT_TRY_ASSIGN(std::optional<Revision> revision, catalogue_.ActiveRevision(flight_id));
  if (!revision) {
    Forget(flight_id);
    return Error{ErrorCode::kNotFound, fmt::format("Flight {} has no map (yet).", flight_id), ""};
  }
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(flight_id);
  if (found != entries_.end()) {
    Entry& entry = found->second;
    entry.newest = std::max(entry.newest, revision->revision);
    if (entry.tileset->revision.revision >= revision->revision) entry.checked = entry.used = read_at;
  }
  return *std::move(revision);
}

ReadAgain::Read TilesetCache::Looking(const std::string& flight_id) {
  return [this, flight_id]() -> Result<void> {
    SKYQUILT_TRY(Look(flight_id));
    return {};
  };
}

Result<std::shared_ptr<const Tileset>> TilesetCache::Refresh(const std::string& flight_id) {
  // Only a revision retired twice within one request can vanish between the query and the opening.
  constexpr int kTries = 3;
  for (int attempt = 1;; ++attempt) {
    const auto read_at = std::chrono::steady_clock::now();
    SKYQUILT_TRY_ASSIGN(const Revision revision, Look(flight_id));
    {
      const std::lock_guard lock(mutex_);
      const auto found = entries_.find(flight_id);
      if (found != entries_.end() && found->second.tileset->revision.revision >= revision.revision)
        return found->second.tileset;
    }
    Result<Tileset> opened = blobs_ != nullptr
                                 ? OpenInObjectStore(flight_id, revision, blobs_, memory_)
                                 : OpenHere(flight_id, revision, dir_.Revision(flight_id, revision.revision));
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

std::shared_ptr<const Tileset> TilesetCache::AtHand(const std::string& flight_id) {
  const auto now = std::chrono::steady_clock::now();
  std::shared_ptr<const Tileset> shown;
  {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(flight_id);
    if (found == entries_.end()) return nullptr;
    shown = found->second.tileset;
    if (now - found->second.checked < kFreshFor) {
      found->second.used = now;
      return shown;
    }
  }
  if (!is_shared_ && blobs_ == nullptr) {
    const Result<std::shared_ptr<const Tileset>> newest = Get(flight_id);
    return newest ? *newest : nullptr;
  }
  if (!is_shared_ || again_.IsWell()) return nullptr;
  again_.Begin(flight_id, Looking(flight_id));
  return shown;
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
