// Previews: which flights have a preview, its progress, and which photos wait to be drawn; PreviewTiles: the
// tiles of one; PreviewCache: the one that a flight shows now. A flight has a preview while it has no map:
// publishing the map ends it in the same transaction. Any thread, any number of processes, of which one
// draws. Errors: kUnavailable, kIo; of the tiles also kNotFound (the preview has ended, or the flight has
// none), kCorrupt, kOutOfSpace.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/geo/tile_id.h"
#include "storage/catalogue/catalogue.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/sqlite_db.h"
#include "storage/files/data_dir.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

struct Preview {
  std::string flight_id;
  std::string folder;  // below the flight's, with PreviewTiles in it; another one after a start from new
  std::int64_t edition = 0;
  std::int64_t photos = 0;  // that are drawn
  int min_zoom = 0;
  int max_zoom = 0;
  geo::LatLonBounds bounds;
  geo::LatLonBounds changed;  // what the latest edition changed
};

// Photos to draw.
struct PreviewWork {
  std::string flight_id;
  std::vector<StoredFile> fresh;
  std::vector<StoredFile> tried;  // before them: they say which way the flight goes
};

class Previews {
 public:
  explicit Previews(CatalogueDb& db) : db_(db) {}

  // Files that nobody tried yet, at most `limit` and of one flight, the one of which least is drawn. They
  // count as tried from now on: a photo that kills whoever draws it is not taken up again.
  Result<std::optional<PreviewWork>> Claim(int limit);
  // These turned out to have no part in the preview: it does not depend on them.
  Result<void> Forgo(const std::vector<StoredFile>& files);
  // Nobody tried these after all: whoever claimed them was stopped before it was done, or found no room.
  Result<void> GiveBack(const std::vector<StoredFile>& files);
  Result<std::optional<Preview>> Find(const std::string& flight_id) const;
  // Shows an edition. False: the flight is gone, has its map by now, or was begun anew; nothing is shown
  // then.
  Result<bool> Show(const Preview& preview);

 private:
  Result<void> Mark(const std::vector<StoredFile>& files, int state);
  CatalogueDb& db_;
};

// The name of a new preview folder; all have names that begin so.
inline constexpr const char* kPreviewFolderPrefix = "preview-";
std::string NewPreviewFolder();

// They grow while they are read: one process writes editions, each whole or not at all, others read. A file
// of its own (SQLite, WAL) and nothing that must survive: it is drawn anew from the photos.
class PreviewTiles final : public TileSource {
 public:
  using Tiles = std::map<geo::TileId, std::string>;

  // `folder` is there already. Makes an empty tileset where there is none.
  static Result<std::shared_ptr<PreviewTiles>> Open(const std::filesystem::path& folder);
  // Never makes one.
  static Result<std::shared_ptr<PreviewTiles>> OpenToRead(const std::filesystem::path& folder);

  // With its bytes.
  Result<std::optional<FoundTile>> Find(const geo::TileId& tile) override;
  // All or none; a tile that is there already is replaced.
  Result<void> Put(const Tiles& tiles);

 private:
  explicit PreviewTiles(SqliteDb db) : db_(std::move(db)) {}
  std::mutex mutex_;
  SqliteDb db_;
};

struct OpenPreview {
  Preview preview;
  std::shared_ptr<PreviewTiles> tiles;
};

// Opened once and kept while it is used. Another process draws, so the catalogue is read again after
// kFreshFor.
class PreviewCache {
 public:
  static constexpr std::chrono::milliseconds kFreshFor{100};
  static constexpr std::size_t kMaxOpen = 64;

  PreviewCache(DataDir dir, CatalogueDb& db) : dir_(std::move(dir)), previews_(db) {}
  Result<std::shared_ptr<const OpenPreview>> Get(const std::string& flight_id);

 private:
  struct Entry {
    std::shared_ptr<const OpenPreview> open;
    std::chrono::steady_clock::time_point checked;
  };
  DataDir dir_;
  const Previews previews_;
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace skyquilt::storage
