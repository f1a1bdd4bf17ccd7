#include "storage/tilesets/preview_tiles.h"

#include <xxhash.h>

#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kFileName = "tiles.db";

}  // namespace

Result<std::shared_ptr<PreviewTiles>> PreviewTiles::Open(const std::filesystem::path& folder) {
  SKYQUILT_TRY_ASSIGN(SqliteDb db, SqliteDb::Open(folder / kFileName, OpenMode::kReadWriteCreate));
  SKYQUILT_TRY(db.Exec(
      "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;"
      "CREATE TABLE IF NOT EXISTS tile(zoom INTEGER, x INTEGER, y INTEGER, bytes BLOB, UNIQUE(zoom, x, y))"));
  return std::shared_ptr<PreviewTiles>(new PreviewTiles(std::move(db)));
}

Result<std::shared_ptr<PreviewTiles>> PreviewTiles::OpenToRead(const std::filesystem::path& folder) {
  std::error_code missing;
  if (!std::filesystem::exists(folder / kFileName, missing)) {
    return Error{ErrorCode::kNotFound, "The preview has ended.", folder.string()};
  }
  return Open(folder);
}

Result<std::optional<FoundTile>> PreviewTiles::Find(const geo::TileId& tile) {
  const std::lock_guard lock(mutex_);
  SKYQUILT_TRY_ASSIGN(Statement query, db_.Query("SELECT bytes FROM tile WHERE zoom=? AND x=? AND y=?",
                                                 tile.z(), std::int64_t{tile.x()}, std::int64_t{tile.y()}));
  return query.First([](const Statement& row) {
    const auto blob = row.ColumnBlob(0);
    return FoundTile{XXH3_64bits(blob.data(), blob.size()),
                     std::string(reinterpret_cast<const char*>(blob.data()), blob.size())};
  });
}

Result<std::string> PreviewTiles::Load(FoundTile tile) {
  SKYQUILT_CHECK(tile.bytes.has_value(), "the preview finds tiles with their bytes");
  return *std::move(tile.bytes);
}

Result<void> PreviewTiles::Put(const Tiles& tiles) {
  const std::lock_guard lock(mutex_);
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(db_));
  {
    SKYQUILT_TRY_ASSIGN(Statement write, db_.Prepare("INSERT OR REPLACE INTO tile VALUES(?,?,?,?)"));
    for (const auto& [tile, bytes] : tiles) {
      const std::span blob(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
      SKYQUILT_TRY(write.BindAll(tile.z(), std::int64_t{tile.x()}, std::int64_t{tile.y()}, blob).Run());
    }
  }
  return transaction.Commit();
}

}  // namespace skyquilt::storage
