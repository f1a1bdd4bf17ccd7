#include "storage/tilesets/map_files.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::storage {

namespace fs = std::filesystem;

MapFiles FinishedMap(const fs::path& folder) { return {folder / "mosaic.mbtiles", folder / "mosaic.state"}; }
MapFiles TemporaryMap(const fs::path& folder) {
  return {folder / "mosaic.mbtiles.tmp", folder / "mosaic.state.tmp"};
}
MapFiles LeftOverMap(const fs::path& folder) {
  return {folder / "mosaic.mbtiles.part", folder / "mosaic.state.part"};
}

std::string JournalOf(const fs::path& file) { return file.string() + "-journal"; }

void RemoveMap(const MapFiles& paths) {
  std::error_code gone;  // a file that will not go is overwritten by the next run
  for (const fs::path& file : {paths.tiles, paths.state}) {
    fs::remove(file, gone);
    fs::remove(JournalOf(file), gone);
  }
}

void SetMapAside(const fs::path& folder) {
  const MapFiles from = TemporaryMap(folder), to = LeftOverMap(folder);
  std::error_code none;  // nothing left, or not to be moved: then there is nothing to go on from
  if (!fs::exists(from.state, none) || !fs::exists(from.tiles, none)) return;
  RemoveMap(to);
  for (const auto& [source, target] : {std::pair{from.tiles, to.tiles}, std::pair{from.state, to.state}}) {
    if (fs::exists(JournalOf(source), none)) fs::rename(JournalOf(source), JournalOf(target), none);
    fs::rename(source, target, none);
  }
}

namespace {

// As they were rendered, row by row from the north (core/render/render_tiles): SQLite's pages lie as the
// tiles come, and a map that is put together is to have the bytes of one that was not.
constexpr const char* kTilesOfLevel =
    "SELECT tile_column, tile_row, tile_data FROM tiles WHERE zoom_level = ?1 "
    "AND tile_column BETWEEN ?2 AND ?3 AND tile_row BETWEEN ?4 AND ?5 ORDER BY tile_row DESC, tile_column";

// Whether each content is what its key says: what a power cut kept from the disk may lie within a tile, where
// SQLite does not see it.
Result<void> CheckContents(SqliteDb& tiles) {
  constexpr std::int64_t kMaxOfOneKey = 16;
  SKYQUILT_TRY_ASSIGN(Statement contents, tiles.Prepare("SELECT tile_data_id, tile_data FROM tiles_data"));
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, contents.Step());
    if (!row) return {};
    const std::int64_t behind = contents.ColumnInt64(0) - ContentIdOf(contents.ColumnBlob(1));
    if (behind < 0 || behind > kMaxOfOneKey)
      return Error{ErrorCode::kCorrupt, "a tile that a killed run left is not the one that was put", ""};
  }
}

}  // namespace

Result<std::unique_ptr<EarlierMap>> OpenEarlierMap(const MapFiles& paths, bool is_finished) {
  auto earlier = std::make_unique<EarlierMap>();
  // A file of a killed run is first rolled back to its last commit, which needs writing.
  const OpenMode mode = is_finished ? OpenMode::kReadOnlyImmutable : OpenMode::kReadWriteCreate;
  SKYQUILT_TRY_ASSIGN(earlier->tiles, SqliteDb::Open(paths.tiles, mode));
  SKYQUILT_TRY_ASSIGN(earlier->state, SqliteDb::Open(paths.state, mode));
  SqliteDb &tiles_db = earlier->tiles, &state = earlier->state;
  if (!is_finished) SKYQUILT_TRY(CheckContents(tiles_db));
  SKYQUILT_TRY_ASSIGN(earlier->select_tiles, tiles_db.Prepare(kTilesOfLevel));
  SKYQUILT_TRY_ASSIGN(const std::int64_t count, tiles_db.Number("SELECT count(*) FROM tiles_shallow"));
  SKYQUILT_TRY_ASSIGN(
      earlier->select_block,
      state.Prepare("SELECT levels, tiles, base_tiles, covered_pixels, west, south, east, north FROM blocks "
                    "WHERE zoom = ?1 AND column = ?2 AND row = ?3"));
  SKYQUILT_TRY_ASSIGN(Statement facts, state.Query("SELECT name, bytes FROM facts"));
  SKYQUILT_TRY_ASSIGN(Statement digests, state.Query("SELECT zoom, column, row, digest FROM blocks"));
  const Error other_map{ErrorCode::kCorrupt, "the memory of the map belongs to another map", ""};
  std::string tiles;
  SKYQUILT_TRY(facts.Each([&](const Statement& row) {
    const auto bytes = row.ColumnBlob(1);
    std::string& fact = row.ColumnText(0) == "flight" ? earlier->facts : tiles;
    fact.assign(bytes.begin(), bytes.end());
  }));
  if (is_finished && tiles != std::to_string(count)) return other_map;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, digests.Step());
    if (!row) break;
    const auto tile =
        geo::TileId::Make(digests.ColumnInt64(0), digests.ColumnInt64(1), digests.ColumnInt64(2));
    const auto bytes = digests.ColumnBlob(3);
    Digest digest;
    if (!tile || bytes.size() != digest.size()) return other_map;
    std::copy(bytes.begin(), bytes.end(), digest.begin());
    earlier->digests[*tile] = digest;
  }
  return earlier;
}

}  // namespace skyquilt::storage
