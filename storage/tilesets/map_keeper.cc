#include "storage/tilesets/map_keeper.h"

#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "core/image/fringe_encoder.h"
#include "core/image/picture_codec.h"
#include "core/image/picture_format.h"
#include "storage/db/sqlite_db.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/map_files.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;
using pyramid::KeptBlock;

constexpr const char* kKeeperSchema = R"sql(
PRAGMA journal_mode = DELETE;
PRAGMA synchronous = OFF;
BEGIN;
CREATE TABLE blocks (zoom INTEGER NOT NULL, column INTEGER NOT NULL, row INTEGER NOT NULL, levels INTEGER NOT NULL,
  digest BLOB NOT NULL, tiles INTEGER NOT NULL, base_tiles INTEGER NOT NULL, covered_pixels INTEGER NOT NULL,
  west REAL, south REAL, east REAL, north REAL, PRIMARY KEY (zoom, column, row));
CREATE TABLE facts (name TEXT NOT NULL PRIMARY KEY, bytes BLOB NOT NULL);
)sql";
constexpr int kBlocksACommit = 8;

image::PictureFormat FormatOf(std::span<const std::uint8_t> bytes) {
  return image::PictureFormatOf({reinterpret_cast<const char*>(bytes.data()), bytes.size()})
      .value_or(image::PictureFormat::kJpeg);
}

}  // namespace

struct MapKeeper::State {
  fs::path folder;
  std::unique_ptr<MbtilesWriter> writer;
  SqliteDb db;
  Statement keep, remember;
  std::vector<std::unique_ptr<EarlierMap>> earlier;  // the most recent first
  std::string facts_of_parts;
  std::int64_t tiles = 0;
  int uncommitted = 0;
  bool is_published = false;

  EarlierMap* Of(const geo::TileId& block) const {
    for (const auto& one : earlier) {
      if (one->digests.contains(block)) return one.get();
    }
    return nullptr;
  }

  // Tiles first: a block that is remembered has its tiles.
  Result<void> Commit() {
    uncommitted = 0;
    SKYQUILT_TRY(writer->Commit());
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
  RemoveMap(TemporaryMap(state_->folder));
  RemoveMap(LeftOverMap(state_->folder));
}

Result<std::unique_ptr<MapKeeper>> MapKeeper::Create(const fs::path& folder, const fs::path& previous,
                                                     MapParts parts) {
  auto state = std::make_unique<State>();
  state->folder = folder;
  SetMapAside(folder);
  const auto look = [&](const MapFiles& paths, bool is_finished) {
    std::error_code none;
    if (!fs::exists(paths.state, none) || !fs::exists(paths.tiles, none)) return;
    // One that cannot be read is as good as none: everything is rendered anew.
    if (auto earlier = OpenEarlierMap(paths, is_finished)) state->earlier.push_back(*std::move(earlier));
  };
  state->facts_of_parts = std::move(parts.facts);
  for (const fs::path& part : parts.folders) look(FinishedMap(part), true);
  look(LeftOverMap(folder), false);
  look(FinishedMap(previous.empty() ? folder : previous), true);
  SKYQUILT_TRY_ASSIGN(state->writer, MbtilesWriter::Create(folder / "mosaic.mbtiles"));
  const fs::path temporary = TemporaryMap(folder).state;
  std::error_code removed;
  fs::remove(temporary, removed);
  fs::remove(JournalOf(temporary), removed);
  SKYQUILT_TRY_ASSIGN(state->db, SqliteDb::Open(temporary, OpenMode::kReadWriteCreate));
  SKYQUILT_TRY(state->db.Exec(kKeeperSchema));
  SKYQUILT_TRY_ASSIGN(
      state->keep, state->db.Prepare("INSERT INTO blocks VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12)"));
  SKYQUILT_TRY_ASSIGN(state->remember, state->db.Prepare("INSERT OR REPLACE INTO facts VALUES (?1, ?2)"));
  return std::unique_ptr<MapKeeper>(new MapKeeper(std::move(state)));
}

Result<std::string> MapKeeper::FactsOf(const fs::path& folder) {
  const auto earlier = OpenEarlierMap(FinishedMap(folder), true);
  if (!earlier || (*earlier)->facts.empty()) {
    return Error{
        ErrorCode::kNotFound,
        "The folder " + folder.string() +
            " has no map that can be added to: mosaic.mbtiles and mosaic.state are needed. Stitch all photos.",
        earlier ? "" : earlier.error().message};
  }
  return std::move((*earlier)->facts);
}

Result<std::string> MapKeeper::StatedFacts(const fs::path& folder) {
  std::error_code none;
  fs::path path = FinishedMap(folder).state;
  const MapFiles temporary = TemporaryMap(folder);
  if (!fs::exists(path, none) && !fs::exists(temporary.tiles, none)) path = temporary.state;
  const Error unknown{ErrorCode::kNotFound, folder.string() + " has no mosaic.state that can be read", ""};
  if (!fs::exists(path, none)) return unknown;
  auto state = SqliteDb::Open(path, OpenMode::kReadOnlyImmutable);
  if (!state) return unknown;
  auto query = state->Prepare("SELECT bytes FROM facts WHERE name='flight'");
  if (!query) return unknown;
  const Result<bool> row = query->Step();
  if (!row || !*row) return unknown;
  const auto bytes = query->ColumnBlob(0);
  return std::string(bytes.begin(), bytes.end());
}

Result<void> MapKeeper::Put(const geo::TileId& tile, image::PictureFormat format,
                            std::span<const std::uint8_t> bytes) {
  ++state_->tiles;
  return state_->writer->Put(tile, format, bytes);
}

std::optional<Digest> MapKeeper::DigestOf(const geo::TileId& block) const {
  const EarlierMap* earlier = state_->Of(block);
  if (earlier == nullptr) return std::nullopt;
  return earlier->digests.at(block);
}

Result<KeptBlock> MapKeeper::Reuse(const geo::TileId& block, const Digest& digest,
                                   std::optional<int> fringe_quality) {
  EarlierMap& earlier = *state_->Of(block);
  Statement& row = earlier.select_block;
  SKYQUILT_TRY(row.BindAll(block.z(), std::int64_t{block.x()}, std::int64_t{block.y()}).Step());
  KeptBlock kept;
  kept.levels = static_cast<int>(row.ColumnInt64(0));
  kept.tiles = row.ColumnInt64(1);
  kept.base_tiles = row.ColumnInt64(2);
  kept.covered_pixels = row.ColumnInt64(3);
  if (!row.IsNull(4)) {
    kept.covered_in_merc.Include(Eigen::Vector2d(row.ColumnDouble(4), row.ColumnDouble(5)));
    kept.covered_in_merc.Include(Eigen::Vector2d(row.ColumnDouble(6), row.ColumnDouble(7)));
  }
  row.Reset();
  std::int64_t tiles = 0;
  for (int level = kept.levels; level >= 0; --level) {  // as they were rendered
    const int zoom = block.z() + level;
    const std::int64_t side = std::int64_t{1} << level;
    const std::int64_t first_column = std::int64_t{block.x()} * side;
    const std::int64_t first_row = std::int64_t{block.TmsRow()} * side;
    Statement& select = earlier.select_tiles;
    select.BindAll(zoom, first_column, first_column + side - 1, first_row, first_row + side - 1);
    while (true) {
      SKYQUILT_TRY_ASSIGN(const bool more, select.Step());
      if (!more) break;
      SKYQUILT_TRY_ASSIGN(const auto tile,
                          geo::TileId::Make(zoom, select.ColumnInt64(0),
                                            (std::int64_t{1} << zoom) - 1 - select.ColumnInt64(1)));
      const auto bytes = select.ColumnBlob(2);
      if (level == 0) kept.topmost.assign(bytes.begin(), bytes.end());
      if (fringe_quality && FormatOf(bytes) == image::PictureFormat::kPng) {
        SKYQUILT_TRY_ASSIGN(
            const image::RgbaImage picture,
            image::DecodePicture({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
        const std::vector<std::uint8_t> fringe = image::EncodeFringe(picture, *fringe_quality);
        if (level == 0) kept.topmost = fringe;
        SKYQUILT_TRY(Put(tile, image::PictureFormat::kWebp, fringe));
      } else {
        SKYQUILT_TRY(Put(tile, FormatOf(bytes), bytes));
      }
      ++tiles;
    }
    select.Reset();
  }
  if (tiles != kept.tiles) {
    return Error{ErrorCode::kCorrupt,
                 "The file mosaic.state beside the map is damaged. Delete it and stitch again.", ""};
  }
  SKYQUILT_TRY(Keep(block, digest, kept));
  return kept;
}

Result<void> MapKeeper::Keep(const geo::TileId& block, const Digest& digest, const KeptBlock& kept) {
  Statement& row = state_->keep;
  row.BindAll(block.z(), std::int64_t{block.x()}, std::int64_t{block.y()}, kept.levels,
              std::span<const std::uint8_t>(digest), kept.tiles, kept.base_tiles, kept.covered_pixels);
  if (kept.covered_in_merc.IsEmpty()) {
    for (int column = 9; column <= 12; ++column) row.BindNull(column);
  } else {
    row.Bind(9, kept.covered_in_merc.min.x()).Bind(10, kept.covered_in_merc.min.y());
    row.Bind(11, kept.covered_in_merc.max.x()).Bind(12, kept.covered_in_merc.max.y());
  }
  SKYQUILT_TRY(row.Run());
  if (++state_->uncommitted < kBlocksACommit) return {};
  return state_->Commit();
}

const std::string& MapKeeper::Recall() const {
  static const std::string kNothing;
  if (!state_->facts_of_parts.empty()) return state_->facts_of_parts;
  for (const auto& earlier : state_->earlier) {
    if (!earlier->facts.empty()) return earlier->facts;
  }
  return kNothing;
}

Result<void> MapKeeper::Remember(std::string_view facts) {
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(facts.data()), facts.size());
  SKYQUILT_TRY(state_->remember.BindAll("flight", bytes).Run());
  return state_->Commit();
}

Result<void> MapKeeper::Publish(const TilesetMetadata& metadata) {
  const std::string tiles = std::to_string(state_->tiles);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(tiles.data()), tiles.size());
  SKYQUILT_TRY(state_->remember.BindAll("tiles", bytes).Run());
  state_->CloseState();
  SKYQUILT_TRY(state_->db.Exec("COMMIT"));
  SKYQUILT_TRY(state_->db.Close());
  // A map never lies beside the state of another.
  const MapFiles finished = FinishedMap(state_->folder);
  std::error_code gone;
  fs::remove(finished.state, gone);
  if (gone)
    return Error{ErrorCode::kIo,
                 "The file " + finished.state.string() + " cannot be replaced: " + gone.message() + ".", ""};
  SKYQUILT_TRY(state_->writer->Publish(metadata));
  SKYQUILT_TRY(PublishFile(TemporaryMap(state_->folder).state, finished.state));
  state_->is_published = true;
  state_->earlier.clear();
  RemoveMap(LeftOverMap(state_->folder));
  return {};
}

}  // namespace skyquilt::storage
