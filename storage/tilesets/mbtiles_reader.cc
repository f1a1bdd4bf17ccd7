#include "storage/tilesets/mbtiles_reader.h"

#include <xxhash.h>

#include <algorithm>
#include <optional>
#include <thread>
#include <utility>

#include "core/base/try.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kFindId =
    "SELECT tile_data_id FROM tiles_shallow WHERE zoom_level=? AND tile_column=? AND tile_row=?";
constexpr const char* kLoadById = "SELECT tile_data FROM tiles_data WHERE tile_data_id=?";
constexpr const char* kFindBytes =
    "SELECT tile_data FROM tiles WHERE zoom_level=? AND tile_column=? AND tile_row=? LIMIT 1";

// Integer keys only: a text key (as other tools have it) takes the general way.
constexpr const char* kHasIntegerKeys =
    "SELECT (SELECT count(*) FROM pragma_table_info('tiles_shallow') WHERE name IN"
    " ('zoom_level','tile_column','tile_row') OR (name='tile_data_id' AND upper(type)='INTEGER'))"
    " + (SELECT count(*) FROM pragma_table_info('tiles_data') WHERE name='tile_data'"
    " OR (name='tile_data_id' AND upper(type)='INTEGER' AND pk=1))";
constexpr int kColumnsOfIntegerKeys = 6;

// Of all that it says of itself.
constexpr std::size_t kMaxTilesetFactsBytes = std::size_t{4} << 20;

Result<SqliteDb> OpenTileset(const std::filesystem::path& path) {
  Result<SqliteDb> db = SqliteDb::Open(path, OpenMode::kReadOnlyImmutable);
  if (db) db->LimitValues(kMaxTileBytes);
  return db;
}

Error DamagedTileset(std::string detail) {
  return {ErrorCode::kCorrupt, "The stored tiles of the map are damaged. Stitch the flight again.",
          std::move(detail)};
}

// What is larger than any tile is none.
Result<bool> NextRow(Statement& statement) {
  Result<bool> row = statement.Step();
  if (row || row.error().code != ErrorCode::kTooLarge) return row;
  return DamagedTileset(row.error().detail);
}

Result<TilesetFacts> ReadMetadata(Statement& rows, const std::filesystem::path& path) {
  TilesetFacts metadata;
  std::size_t bytes = 0;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool more, NextRow(rows));
    if (!more) return metadata;
    const std::string_view name = rows.ColumnText(0), value = rows.ColumnText(1);
    bytes += name.size() + value.size();
    if (bytes > kMaxTilesetFactsBytes) return DamagedTileset(path.string());
    metadata[std::string(name)] = std::string(value);
  }
}

std::string BlobOf(const Statement& row) {
  const auto blob = row.ColumnBlob(0);
  return std::string(reinterpret_cast<const char*>(blob.data()), blob.size());
}

}  // namespace

struct MbtilesReader::Connection {
  SqliteDb db;
  Statement find;        // kFindId or kFindBytes
  Statement load;        // kLoadById, or nothing
  SqliteBlobs bytes;     // the same; what it cannot read, `load` says
  std::thread::id user;  // the last one, in whose processor's cache its pages are
};

MbtilesReader::MbtilesReader(std::filesystem::path path) : path_(std::move(path)) {}
MbtilesReader::~MbtilesReader() = default;

Result<std::shared_ptr<MbtilesReader>> MbtilesReader::Open(const std::filesystem::path& path) {
  std::shared_ptr<MbtilesReader> reader(new MbtilesReader(path));
  SKYQUILT_TRY_ASSIGN(SqliteDb db, OpenTileset(path));
  {
    SKYQUILT_TRY_ASSIGN(const std::int64_t columns, db.Number(kHasIntegerKeys));
    reader->is_deduplicated_ = columns == kColumnsOfIntegerKeys;
    Result<Statement> metadata = db.Prepare("SELECT name, value FROM metadata");
    if (!metadata) return Error{ErrorCode::kCorrupt, "This is not an MBTiles file.", metadata.error().detail};
    SKYQUILT_TRY_ASSIGN(reader->metadata_, ReadMetadata(*metadata, path));
  }
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<Connection> first, reader->Connect());
  reader->idle_.push_back(std::move(first));
  return reader;
}

Result<std::unique_ptr<MbtilesReader::Connection>> MbtilesReader::Connect() const {
  auto connection = std::make_unique<Connection>();
  SKYQUILT_TRY_ASSIGN(connection->db, OpenTileset(path_));
  SKYQUILT_TRY_ASSIGN(connection->find, connection->db.Prepare(is_deduplicated_ ? kFindId : kFindBytes));
  if (is_deduplicated_) {
    SKYQUILT_TRY_ASSIGN(connection->load, connection->db.Prepare(kLoadById));
    connection->bytes = connection->db.Blobs("tiles_data", "tile_data");
  }
  return connection;
}

// A connection for one call: back in the pool, its statements reset, however the call ends.
struct MbtilesReader::Returner {
  MbtilesReader& owner;
  void operator()(Connection* connection) const {
    connection->find.Reset();
    connection->load.Reset();
    const std::lock_guard lock(owner.mutex_);
    owner.idle_.emplace_back(connection);
  }
};

Result<MbtilesReader::Borrowed> MbtilesReader::Borrow() {
  const std::thread::id me = std::this_thread::get_id();
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      auto taken = std::find_if(idle_.begin(), idle_.end(), [&](const auto& one) { return one->user == me; });
      if (taken == idle_.end()) --taken;
      Borrowed connection(taken->release(), Returner{*this});
      idle_.erase(taken);
      connection->user = me;
      return connection;
    }
  }
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<Connection> made, Connect());
  made->user = me;
  return Borrowed(made.release(), Returner{*this});
}

Result<std::optional<FoundTile>> MbtilesReader::Find(const geo::TileId& tile) {
  SKYQUILT_TRY_ASSIGN(const Borrowed connection, Borrow());
  Statement& find = connection->find;
  find.BindAll(tile.z(), std::int64_t{tile.x()}, std::int64_t{tile.TmsRow()});
  SKYQUILT_TRY_ASSIGN(const bool row, NextRow(find));
  if (!row) return std::optional<FoundTile>();
  FoundTile found;
  if (is_deduplicated_) {
    found.content_id = static_cast<std::uint64_t>(find.ColumnInt64(0));
  } else {
    found.bytes = BlobOf(find);
    found.content_id = XXH3_64bits(found.bytes->data(), found.bytes->size());
  }
  return std::optional<FoundTile>(std::move(found));
}

Result<std::string> MbtilesReader::Load(FoundTile tile) {
  if (tile.bytes) return *std::move(tile.bytes);
  SKYQUILT_TRY_ASSIGN(const Borrowed connection, Borrow());
  const auto id = static_cast<std::int64_t>(tile.content_id);
  if (std::optional<std::string> bytes = connection->bytes.Read(id)) return *std::move(bytes);
  SKYQUILT_TRY_ASSIGN(const bool row, NextRow(connection->load.Bind(1, id)));
  if (!row) {
    return Error{ErrorCode::kCorrupt, "The tileset lacks the bytes of a tile. Stitch the flight again.",
                 path_.string()};
  }
  return BlobOf(connection->load);
}

}  // namespace skyquilt::storage
