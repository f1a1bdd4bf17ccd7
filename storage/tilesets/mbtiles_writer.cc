#include "storage/tilesets/mbtiles_writer.h"

#include <fmt/core.h>
#include <xxhash.h>

#include <cstring>
#include <optional>
#include <set>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/image/picture_format.h"
#include "storage/db/sqlite_db.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kSchema = R"sql(
PRAGMA page_size = 4096;
PRAGMA journal_mode = DELETE;
PRAGMA synchronous = OFF;
PRAGMA locking_mode = EXCLUSIVE;
PRAGMA application_id = 0x4d504258;
BEGIN;
CREATE TABLE metadata (name TEXT NOT NULL UNIQUE, value TEXT);
CREATE TABLE tiles_shallow (zoom_level INTEGER NOT NULL, tile_column INTEGER NOT NULL, tile_row INTEGER NOT NULL,
  tile_data_id INTEGER NOT NULL, tile_bytes INTEGER NOT NULL, tile_format INTEGER NOT NULL,
  PRIMARY KEY (zoom_level, tile_column, tile_row)) WITHOUT ROWID;
CREATE TABLE tiles_data (tile_data_id INTEGER PRIMARY KEY, tile_data BLOB NOT NULL);
CREATE VIEW tiles AS SELECT s.zoom_level AS zoom_level, s.tile_column AS tile_column, s.tile_row AS tile_row,
  d.tile_data AS tile_data FROM tiles_shallow s JOIN tiles_data d ON s.tile_data_id = d.tile_data_id;
)sql";

}  // namespace

struct MbtilesWriter::State {
  std::filesystem::path path;
  std::filesystem::path temporary;
  SqliteDb db;
  Statement find_bytes;
  Statement add_bytes;
  Statement add_tile;
  std::set<image::PictureFormat> formats;
  bool has_opaque_webp = false;
  std::int64_t tiles = 0;
  bool is_published = false;

  void CloseStatements() {
    for (Statement* statement : {&find_bytes, &add_bytes, &add_tile}) *statement = Statement();
  }
};

MbtilesWriter::MbtilesWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}

MbtilesWriter::~MbtilesWriter() {
  if (state_->is_published) return;
  state_->CloseStatements();
  state_->db = SqliteDb();
  std::error_code gone;  // nothing to do about a temporary file that will not go; the next run overwrites it
  std::filesystem::remove(state_->temporary, gone);
  std::filesystem::remove(state_->temporary.string() + "-journal", gone);
}

Result<std::unique_ptr<MbtilesWriter>> MbtilesWriter::Create(const std::filesystem::path& path) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->temporary = path;
  state->temporary += ".tmp";
  std::error_code removed;
  std::filesystem::remove(state->temporary, removed);
  std::filesystem::remove(state->temporary.string() + "-journal", removed);
  SKYQUILT_TRY_ASSIGN(state->db, SqliteDb::Open(state->temporary, OpenMode::kReadWriteCreate));
  SqliteDb& db = state->db;
  SKYQUILT_TRY(db.Exec(kSchema));
  SKYQUILT_TRY_ASSIGN(state->find_bytes,
                      db.Prepare("SELECT tile_data FROM tiles_data WHERE tile_data_id = ?1"));
  SKYQUILT_TRY_ASSIGN(state->add_bytes, db.Prepare("INSERT INTO tiles_data VALUES (?1, ?2)"));
  SKYQUILT_TRY_ASSIGN(state->add_tile,
                      db.Prepare("INSERT INTO tiles_shallow VALUES (?1, ?2, ?3, ?4, ?5, ?6)"));
  return std::unique_ptr<MbtilesWriter>(new MbtilesWriter(std::move(state)));
}

std::int64_t ContentIdOf(std::span<const std::uint8_t> bytes) {
  // 63 bits, so that it is a positive row id of SQLite.
  return static_cast<std::int64_t>(XXH3_64bits(bytes.data(), bytes.size()) >> 1);
}

Result<void> MbtilesWriter::Put(const geo::TileId& tile, image::PictureFormat format,
                                std::span<const std::uint8_t> bytes) {
  std::int64_t id = ContentIdOf(bytes);
  while (true) {
    state_->find_bytes.Bind(1, id);
    SKYQUILT_TRY_ASSIGN(const bool found, state_->find_bytes.Step());
    if (!found) {
      state_->find_bytes.Reset();
      SKYQUILT_TRY(state_->add_bytes.BindAll(id, bytes).Run());
      break;
    }
    const std::span<const std::uint8_t> known = state_->find_bytes.ColumnBlob(0);
    const bool is_same =
        known.size() == bytes.size() && std::memcmp(known.data(), bytes.data(), bytes.size()) == 0;
    state_->find_bytes.Reset();
    if (is_same) break;
    id = (id + 1) & 0x7fffffffffffffff;
  }
  state_->formats.insert(format);
  state_->has_opaque_webp |=
      format == image::PictureFormat::kWebp &&
      !image::IsWebpWithAlpha({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  ++state_->tiles;
  return state_->add_tile
      .BindAll(tile.z(), std::int64_t{tile.x()}, std::int64_t{tile.TmsRow()}, id,
               static_cast<std::int64_t>(bytes.size()), image::MbtilesCodeOf(format))
      .Run();
}

Result<void> MbtilesWriter::Commit() { return state_->db.Exec("COMMIT; BEGIN;"); }

// Strict programs (Martin) take the first tile of all and of each zoom for what all are, and refuse a file
// that names another format. Where tiles of two formats are, those come first that lie at the edge.
Result<const char*> MbtilesWriter::NamedFormat() {
  const bool has_jpeg = state_->formats.contains(image::PictureFormat::kJpeg);
  if (!has_jpeg) return state_->formats.contains(image::PictureFormat::kWebp) ? "webp" : "png";
  if (state_->has_opaque_webp) return "jpg";
  SKYQUILT_TRY_ASSIGN(const std::int64_t first,
                      state_->db.Number("SELECT tile_format FROM tiles_shallow"
                                        " ORDER BY zoom_level, tile_column, tile_row LIMIT 1"));
  const std::optional<image::PictureFormat> format = image::PictureFormatOfMbtiles(first);
  SKYQUILT_CHECK(format, "a tile of a format that was not written");
  return image::ExtensionOf(*format);
}

Result<void> MbtilesWriter::Publish(const TilesetMetadata& metadata) {
  const bool has_webp = state_->formats.contains(image::PictureFormat::kWebp);
  SKYQUILT_TRY_ASSIGN(const char* format, NamedFormat());
  const auto& b = metadata.bounds;
  const std::vector<std::pair<std::string, std::string>> rows = {
      {"name", metadata.name},
      {"format", format},
      {"fringe", has_webp && !state_->has_opaque_webp ? "webp" : ""},
      {"bounds",
       fmt::format("{:.12f},{:.12f},{:.12f},{:.12f}", b.west_deg, b.south_deg, b.east_deg, b.north_deg)},
      {"center", fmt::format("{:.8f},{:.8f},{}", b.Middle().lon_deg, b.Middle().lat_deg,
                             std::max(metadata.min_zoom, metadata.max_zoom - 4))},
      {"minzoom", std::to_string(metadata.min_zoom)},
      {"maxzoom", std::to_string(metadata.max_zoom)},
      {"tile_size", std::to_string(metadata.tile_size_px)},
      {"type", "overlay"},
      {"version", metadata.version},
      {"description", metadata.description},
      {"attribution", metadata.attribution},
      {"generator", metadata.generator},
  };
  {
    SKYQUILT_TRY_ASSIGN(auto add, state_->db.Prepare("INSERT INTO metadata VALUES (?1, ?2)"));
    for (const auto& [name, value] : rows) {
      if (value.empty()) continue;
      SKYQUILT_TRY(add.BindAll(name, value).Run());
    }
  }
  state_->CloseStatements();
  SKYQUILT_TRY(state_->db.Exec("COMMIT"));
  SKYQUILT_TRY_ASSIGN(const std::int64_t tiles, state_->db.Number("SELECT count(*) FROM tiles"));
  if (tiles != state_->tiles) {
    return Error{ErrorCode::kCorrupt,
                 "The tileset lost tiles while it was written. Check the disk and stitch again.",
                 state_->temporary};
  }
  SKYQUILT_TRY(state_->db.Close());
  SKYQUILT_TRY(PublishFile(state_->temporary, state_->path));
  state_->is_published = true;
  return {};
}

}  // namespace skyquilt::storage
