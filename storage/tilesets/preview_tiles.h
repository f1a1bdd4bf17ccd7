// PreviewTiles: the tiles of one preview, which grow while they are read: one process writes editions, each
// whole or not at all, others read. A file of its own (SQLite, WAL) and nothing that must survive: it is
// drawn anew from the photos. Any thread. Errors: kNotFound (the preview has ended), kCorrupt, kOutOfSpace,
// kUnavailable, kIo.
#pragma once

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
#include "core/geo/tile_id.h"
#include "storage/db/sqlite_db.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

class PreviewTiles final : public TileSource {
 public:
  using Tiles = std::map<geo::TileId, std::string>;

  // `folder` is there already. Makes an empty tileset where there is none.
  static Result<std::shared_ptr<PreviewTiles>> Open(const std::filesystem::path& folder);
  // Never makes one.
  static Result<std::shared_ptr<PreviewTiles>> OpenToRead(const std::filesystem::path& folder);

  // With its bytes.
  Result<std::optional<FoundTile>> Find(const geo::TileId& tile) override;
  Result<std::string> Load(FoundTile tile) override;
  // All or none; a tile that is there already is replaced.
  Result<void> Put(const Tiles& tiles);

 private:
  explicit PreviewTiles(SqliteDb db) : db_(std::move(db)) {}
  std::mutex mutex_;
  SqliteDb db_;
};

}  // namespace skyquilt::storage
