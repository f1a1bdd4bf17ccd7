#include "tests/storage/small_tileset.h"

#include <algorithm>
#include <fstream>
#include <functional>

#include "core/base/check.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::storage {
namespace {

void Require(const Result<void>& result) {
  SKYQUILT_CHECK(result.ok(), result.ok() ? "" : result.error().detail);
}

}  // namespace

void WriteSmallTileset(const std::filesystem::path& path, TilesetSchema schema,
                       const std::vector<SmallTile>& tiles, int tile_size_px) {
  auto db = *SqliteDb::Open(path, OpenMode::kReadWriteCreate);
  std::string described =
      "CREATE TABLE metadata(name TEXT, value TEXT);"
      "INSERT INTO metadata VALUES('name','small'),('format','png'),('tile_size','";
  Require(db.Exec(described.append(std::to_string(tile_size_px)).append("')")));
  const auto is_webp = [](const SmallTile& tile) { return tile.bytes.starts_with("RIFF"); };
  if (std::any_of(tiles.begin(), tiles.end(), is_webp))
    Require(db.Exec("INSERT INTO metadata VALUES('fringe','webp')"));
  const std::string keys = "(zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, ";
  if (schema == TilesetSchema::kFlat) {
    Require(db.Exec("CREATE TABLE tiles" + keys + "tile_data BLOB)"));
  } else {
    const bool is_text = schema == TilesetSchema::kTextKeys;
    const std::string type = is_text ? "TEXT" : "INTEGER";
    Require(
        db.Exec("CREATE TABLE tiles_shallow" + keys + "tile_data_id " + type +
                ", PRIMARY KEY(zoom_level, tile_column, tile_row)) WITHOUT ROWID;"
                "CREATE TABLE tiles_data(tile_data_id " +
                type +
                " PRIMARY KEY, tile_data BLOB);"
                "CREATE VIEW tiles AS SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles_shallow"
                " JOIN tiles_data USING(tile_data_id)"));
  }
  for (const SmallTile& tile : tiles) {
    const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(tile.bytes.data()),
                                              tile.bytes.size());
    if (schema == TilesetSchema::kFlat) {
      auto insert = *db.Prepare("INSERT INTO tiles VALUES(?,?,?,?)");
      Require(insert.Bind(1, tile.z).Bind(2, tile.x).Bind(3, tile.row).Bind(4, bytes).Run());
      continue;
    }
    const auto id = static_cast<std::int64_t>(std::hash<std::string>()(tile.bytes) >> 1);
    auto data = *db.Prepare("INSERT OR IGNORE INTO tiles_data VALUES(?,?)");
    Require(data.Bind(1, id).Bind(2, bytes).Run());
    auto shallow = *db.Prepare("INSERT INTO tiles_shallow VALUES(?,?,?,?)");
    Require(shallow.Bind(1, tile.z).Bind(2, tile.x).Bind(3, tile.row).Bind(4, id).Run());
  }
}

std::int64_t PublishSmallTileset(const DataDir& dir, CatalogueDb& db, const std::string& flight_id,
                                 const std::vector<SmallTile>& tiles, int tile_size_px,
                                 const std::optional<Revision>& facts) {
  JobQueue queue(db);
  SKYQUILT_CHECK(queue.Add(flight_id, "{}", Now()).ok(), "the job was refused");
  const Lease lease = **queue.Claim("test", Now());
  Revision revision = facts.value_or(Revision{});
  revision.revision = **queue.ReserveRevision(lease);
  if (!facts) revision.bounds = {-180, -85, 180, 85};
  revision.min_zoom = tiles.front().z;
  revision.max_zoom = tiles.back().z;
  const auto folder = dir.Revision(flight_id, revision.revision);
  std::filesystem::create_directories(folder);
  WriteSmallTileset(folder / "mosaic.mbtiles", TilesetSchema::kIntegerKeys, tiles, tile_size_px);
  std::ofstream(folder / "report.json") << "{\"photos\":{}}";
  std::ofstream(folder / "photos.geojson") << "{\"type\":\"FeatureCollection\",\"features\":[]}";
  std::ofstream(folder / "mosaic.tif") << "0123456789";
  SKYQUILT_CHECK(*queue.Publish(lease, revision, Now()), "the lease was lost");
  return revision.revision;
}

}  // namespace skyquilt::storage
