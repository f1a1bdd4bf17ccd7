#include "storage/map_keeper.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "storage/publish_file.h"
#include "storage/sqlite_db.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;
using pipeline::KeptBlock;

constexpr const char* kSchema = R"sql(
PRAGMA journal_mode = DELETE;
PRAGMA synchronous = OFF;
BEGIN;
CREATE TABLE blocks (zoom INTEGER NOT NULL, column INTEGER NOT NULL, row INTEGER NOT NULL, levels INTEGER NOT NULL,
  digest BLOB NOT NULL, tiles INTEGER NOT NULL, base_tiles INTEGER NOT NULL, covered_pixels INTEGER NOT NULL,
  west REAL, south REAL, east REAL, north REAL, half BLOB NOT NULL, PRIMARY KEY (zoom, column, row));
CREATE TABLE facts (name TEXT NOT NULL PRIMARY KEY, bytes BLOB NOT NULL);
)sql";
constexpr const char* kTilesOfLevel =
    "SELECT tile_column, tile_row, tile_data FROM tiles WHERE zoom_level = ?1 AND tile_column BETWEEN ?2 AND "
    "?3 "
    "AND tile_row BETWEEN ?4 AND ?5 ORDER BY tile_column, tile_row";
constexpr int kBlocksACommit = 8;

struct Paths {
  fs::path tiles, state;
};
Paths Finished(const fs::path& folder) { return {folder / "mosaic.mbtiles", folder / "mosaic.state"}; }
Paths Temporary(const fs::path& folder) {
  return {folder / "mosaic.mbtiles.tmp", folder / "mosaic.state.tmp"};
}
Paths LeftOver(const fs::path& folder) {
  return {folder / "mosaic.mbtiles.part", folder / "mosaic.state.part"};
}

std::string JournalOf(const fs::path& file) { return file.string() + "-journal"; }

void Remove(const Paths& paths) {
  std::error_code gone;  // a file that will not go is overwritten by the next run
  for (const fs::path& file : {paths.tiles, paths.state}) {
    fs::remove(file, gone);
    fs::remove(JournalOf(file), gone);
  }
}

// What a killed run left gets out of the way of this one's temporary files. Of several killed runs the last
// one that had got somewhere counts: it took over what the one before had.
void SetAside(const fs::path& folder) {
  const Paths from = Temporary(folder), to = LeftOver(folder);
  std::error_code none;  // nothing left, or not to be moved: then there is nothing to go on from
  if (!fs::exists(from.state, none) || !fs::exists(from.tiles, none)) return;
  Remove(to);
  for (const auto& [source, target] : {std::pair{from.tiles, to.tiles}, std::pair{from.state, to.state}}) {
    if (fs::exists(JournalOf(source), none)) fs::rename(JournalOf(source), JournalOf(target), none);
    fs::rename(source, target, none);
  }
}

pipeline::TileFormat FormatOf(std::span<const std::uint8_t> bytes) {
  if (!bytes.empty() && bytes[0] == 0x89) return pipeline::TileFormat::kPng;
  if (!bytes.empty() && bytes[0] == 'R') return pipeline::TileFormat::kWebp;
  return pipeline::TileFormat::kJpeg;
}

std::vector<std::uint8_t> Deflated(const std::vector<std::uint8_t>& bytes) {
  uLongf size = compressBound(bytes.size());
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, bytes.data(), bytes.size(), 1) != Z_OK) throw std::bad_alloc();
  packed.resize(size);
  return packed;
}

// Halves are squares of RGBA of at most this many bytes.
constexpr uLongf kMostHalfBytes = uLongf{2048} * 2048 * 4;

Result<std::vector<std::uint8_t>> Inflated(std::span<const std::uint8_t> packed) {
  if (packed.empty()) return std::vector<std::uint8_t>();
  for (uLongf room = uLongf{128} * 128 * 4; room <= kMostHalfBytes; room *= 4) {
    std::vector<std::uint8_t> bytes(room);
    uLongf size = room;
    const int done = uncompress(bytes.data(), &size, packed.data(), packed.size());
    if (done == Z_BUF_ERROR) continue;
    if (done != Z_OK || size != room) break;
    return bytes;
  }
  return Error{ErrorCode::kCorrupt, "the memory of the map is damaged; delete mosaic.state and start again",
               ""};
}

// One earlier run, open for reading.
struct Earlier {
  SqliteDb tiles, state;
  Statement select_tiles, select_block;
  std::map<geo::TileId, Digest> digests;
  std::string facts;
};

Result<std::unique_ptr<Earlier>> OpenEarlier(const Paths& paths, bool is_finished) {
  auto earlier = std::make_unique<Earlier>();
  // A file of a killed run is first rolled back to its last commit, which needs writing.
  const OpenMode mode = is_finished ? OpenMode::kReadOnlyImmutable : OpenMode::kReadWriteCreate;
  for (const auto& [db, path] :
       {std::pair{&earlier->tiles, &paths.tiles}, std::pair{&earlier->state, &paths.state}}) {
    auto opened = SqliteDb::Open(*path, mode);
    if (!opened) return opened.error();
    *db = *std::move(opened);
  }
  const auto prepare = [](SqliteDb& db, const char* sql, Statement& statement) -> Result<void> {
    auto prepared = db.Prepare(sql);
    if (!prepared) return prepared.error();
    statement = *std::move(prepared);
    return {};
  };
  Statement count, facts, digests;
  for (const auto& [db, sql, statement] :
       {std::tuple{&earlier->tiles, kTilesOfLevel, &earlier->select_tiles},
        std::tuple{&earlier->tiles, "SELECT count(*) FROM tiles_shallow", &count},
        std::tuple{
            &earlier->state,
            "SELECT levels, tiles, base_tiles, covered_pixels, west, south, east, north, half FROM blocks "
            "WHERE zoom = ?1 AND column = ?2 AND row = ?3",
            &earlier->select_block},
        std::tuple{&earlier->state, "SELECT name, bytes FROM facts", &facts},
        std::tuple{&earlier->state, "SELECT zoom, column, row, digest FROM blocks", &digests}}) {
    if (auto prepared = prepare(*db, sql, *statement); !prepared) return prepared.error();
  }
  const Error other_map{ErrorCode::kCorrupt, "the memory of the map belongs to another map", ""};
  if (auto counted = count.Step(); !counted) return counted.error();
  std::string tiles;
  while (true) {
    const Result<bool> row = facts.Step();
    if (!row) return row.error();
    if (!*row) break;
    const auto bytes = facts.ColumnBlob(1);
    std::string& fact = facts.ColumnText(0) == "flight" ? earlier->facts : tiles;
    fact.assign(bytes.begin(), bytes.end());
  }
  if (is_finished && tiles != std::to_string(count.ColumnInt64(0))) return other_map;
  while (true) {
    const Result<bool> row = digests.Step();
    if (!row) return row.error();
    if (!*row) break;
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

}  // namespace

struct MapKeeper::State {
  fs::path folder;
  std::unique_ptr<MbtilesWriter> writer;
  SqliteDb db;
  Statement keep, remember;
  std::vector<std::unique_ptr<Earlier>> earlier;  // the most recent first
  std::int64_t tiles = 0;
  int uncommitted = 0;
  bool is_published = false;

  Earlier* Of(const geo::TileId& block) const {
    for (const auto& one : earlier) {
      if (one->digests.contains(block)) return one.get();
    }
    return nullptr;
  }

  // Tiles first: a block that is remembered has its tiles.
  Result<void> Commit() {
    uncommitted = 0;
    if (auto committed = writer->Commit(); !committed) return committed;
    return db.Exec("COMMIT; BEGIN;");
  }

  void CloseState() {
    keep = Statement();
    remember = Statement();
  }
};

MapKeeper::MapKeeper(std::unique_ptr<State> state) : state_(std::move(state)) {}

MapKeeper::~MapKeeper() {
  if (state_->is_published) return;
  state_->CloseState();
  state_->db = SqliteDb();
  state_->writer.reset();
  state_->earlier.clear();
  Remove(Temporary(state_->folder));
  Remove(LeftOver(state_->folder));
}

Result<std::unique_ptr<MapKeeper>> MapKeeper::Create(const fs::path& folder, const fs::path& previous) {
  auto state = std::make_unique<State>();
  state->folder = folder;
  SetAside(folder);
  const auto look = [&](const Paths& paths, bool is_finished) {
    std::error_code none;
    if (!fs::exists(paths.state, none) || !fs::exists(paths.tiles, none)) return;
    // One that cannot be read is as good as none: everything is rendered anew.
    if (auto earlier = OpenEarlier(paths, is_finished)) state->earlier.push_back(*std::move(earlier));
  };
  look(LeftOver(folder), false);
  look(Finished(previous.empty() ? folder : previous), true);
  auto writer = MbtilesWriter::Create(folder / "mosaic.mbtiles");
  if (!writer) return writer.error();
  state->writer = *std::move(writer);
  const fs::path temporary = Temporary(folder).state;
  std::error_code removed;
  fs::remove(temporary, removed);
  fs::remove(JournalOf(temporary), removed);
  auto db = SqliteDb::Open(temporary, OpenMode::kReadWriteCreate);
  if (!db) return db.error();
  state->db = *std::move(db);
  if (auto made = state->db.Exec(kSchema); !made) return made.error();
  auto keep = state->db.Prepare("INSERT INTO blocks VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12,?13)");
  if (!keep) return keep.error();
  state->keep = *std::move(keep);
  auto remember = state->db.Prepare("INSERT OR REPLACE INTO facts VALUES (?1, ?2)");
  if (!remember) return remember.error();
  state->remember = *std::move(remember);
  return std::unique_ptr<MapKeeper>(new MapKeeper(std::move(state)));
}

Result<std::string> MapKeeper::FactsOf(const fs::path& folder) {
  const auto earlier = OpenEarlier(Finished(folder), true);
  if (!earlier || (*earlier)->facts.empty()) {
    return Error{ErrorCode::kNotFound,
                 folder.string() + " has no map that can be added to: mosaic.mbtiles and mosaic.state are needed",
                 earlier ? "" : earlier.error().message};
  }
  return std::move((*earlier)->facts);
}

Result<void> MapKeeper::Put(const geo::TileId& tile, pipeline::TileFormat format,
                            std::span<const std::uint8_t> bytes) {
  ++state_->tiles;
  return state_->writer->Put(tile, format, bytes);
}

std::optional<Digest> MapKeeper::DigestOf(const geo::TileId& block) const {
  const Earlier* earlier = state_->Of(block);
  if (earlier == nullptr) return std::nullopt;
  return earlier->digests.at(block);
}

Result<KeptBlock> MapKeeper::Reuse(const geo::TileId& block) {
  Earlier& earlier = *state_->Of(block);
  Statement& row = earlier.select_block;
  row.Bind(1, block.z())
      .Bind(2, static_cast<std::int64_t>(block.x()))
      .Bind(3, static_cast<std::int64_t>(block.y()));
  const Result<bool> found = row.Step();
  if (!found) return found.error();
  KeptBlock kept;
  kept.levels = static_cast<int>(row.ColumnInt64(0));
  kept.tiles = row.ColumnInt64(1);
  kept.base_tiles = row.ColumnInt64(2);
  kept.covered_pixels = row.ColumnInt64(3);
  if (!row.IsNull(4)) {
    kept.covered_in_merc.Include(Eigen::Vector2d(row.ColumnDouble(4), row.ColumnDouble(5)));
    kept.covered_in_merc.Include(Eigen::Vector2d(row.ColumnDouble(6), row.ColumnDouble(7)));
  }
  auto half = Inflated(row.ColumnBlob(8));
  row.Reset();
  if (!half) return half.error();
  kept.half_rgba = *std::move(half);
  std::int64_t tiles = 0;
  for (int level = 0; level <= kept.levels; ++level) {
    const int zoom = block.z() + level;
    const std::int64_t side = std::int64_t{1} << level;
    const std::int64_t first_column = std::int64_t{block.x()} * side;
    const std::int64_t first_row = std::int64_t{block.TmsRow()} * side;
    Statement& select = earlier.select_tiles;
    select.Bind(1, zoom).Bind(2, first_column).Bind(3, first_column + side - 1);
    select.Bind(4, first_row).Bind(5, first_row + side - 1);
    while (true) {
      const Result<bool> more = select.Step();
      if (!more) return more.error();
      if (!*more) break;
      const auto tile = geo::TileId::Make(zoom, select.ColumnInt64(0),
                                          (std::int64_t{1} << zoom) - 1 - select.ColumnInt64(1));
      if (!tile) return tile.error();
      const auto bytes = select.ColumnBlob(2);
      if (auto put = Put(*tile, FormatOf(bytes), bytes); !put) return put.error();
      ++tiles;
    }
    select.Reset();
  }
  if (tiles != kept.tiles) {
    return Error{ErrorCode::kCorrupt, "the memory of the map is damaged; delete mosaic.state and start again",
                 ""};
  }
  if (auto again = Keep(block, earlier.digests.at(block), kept); !again) return again.error();
  return kept;
}

Result<void> MapKeeper::Keep(const geo::TileId& block, const Digest& digest, const KeptBlock& kept) {
  Statement& row = state_->keep;
  const std::vector<std::uint8_t> half =
      kept.half_rgba.empty() ? std::vector<std::uint8_t>() : Deflated(kept.half_rgba);
  row.Bind(1, block.z())
      .Bind(2, static_cast<std::int64_t>(block.x()))
      .Bind(3, static_cast<std::int64_t>(block.y()));
  row.Bind(4, kept.levels).Bind(5, std::span<const std::uint8_t>(digest));
  row.Bind(6, kept.tiles).Bind(7, kept.base_tiles).Bind(8, kept.covered_pixels);
  if (kept.covered_in_merc.IsEmpty()) {
    for (int column = 9; column <= 12; ++column) row.BindNull(column);
  } else {
    row.Bind(9, kept.covered_in_merc.min.x()).Bind(10, kept.covered_in_merc.min.y());
    row.Bind(11, kept.covered_in_merc.max.x()).Bind(12, kept.covered_in_merc.max.y());
  }
  row.Bind(13, std::span<const std::uint8_t>(half));
  if (auto kept_row = row.Run(); !kept_row) return kept_row;
  if (++state_->uncommitted < kBlocksACommit) return {};
  return state_->Commit();
}

const std::string& MapKeeper::Recall() const {
  static const std::string kNothing;
  for (const auto& earlier : state_->earlier) {
    if (!earlier->facts.empty()) return earlier->facts;
  }
  return kNothing;
}

Result<void> MapKeeper::Remember(std::string_view facts) {
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(facts.data()), facts.size());
  if (auto stored = state_->remember.Bind(1, "flight").Bind(2, bytes).Run(); !stored) return stored;
  return state_->Commit();
}

Result<void> MapKeeper::Publish(const TilesetMetadata& metadata) {
  const std::string tiles = std::to_string(state_->tiles);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(tiles.data()), tiles.size());
  if (auto stored = state_->remember.Bind(1, "tiles").Bind(2, bytes).Run(); !stored) return stored;
  state_->CloseState();
  if (auto committed = state_->db.Exec("COMMIT"); !committed) return committed;
  if (auto closed = state_->db.Close(); !closed) return closed;
  // A map never lies beside the state of another.
  const Paths finished = Finished(state_->folder);
  std::error_code gone;
  fs::remove(finished.state, gone);
  if (gone)
    return Error{ErrorCode::kIo, "cannot replace " + finished.state.string() + ": " + gone.message(), ""};
  if (auto published = state_->writer->Publish(metadata); !published) return published;
  if (auto published = PublishFile(Temporary(state_->folder).state, finished.state); !published)
    return published;
  state_->is_published = true;
  state_->earlier.clear();
  Remove(LeftOver(state_->folder));
  return {};
}

}  // namespace skyquilt::storage
