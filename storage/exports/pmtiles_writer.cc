#include "storage/exports/pmtiles_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/base/try.h"
#include "storage/db/sqlite_db.h"
#include "storage/exports/gzip.h"
#include "storage/exports/pmtiles_directory.h"
#include "storage/tilesets/stream_file.h"

namespace skyquilt::storage {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the file is written in the byte order of the machine");

using Metadata = std::map<std::string, std::string>;

constexpr std::uint8_t kVersion = 3, kGzip = 2, kUncompressed = 1;

struct TileRow {
  std::uint64_t number = 0;
  std::int64_t content = 0;  // tile_data_id
  std::uint32_t length = 0;
};

struct Layout {
  std::vector<PmtilesEntry> entries;
  std::vector<std::int64_t> contents;  // in the order of the file
  std::uint64_t tiles = 0;
  std::uint64_t bytes = 0;
  int min_zoom = 0, max_zoom = 0;
};

Result<Metadata> ReadMetadata(SqliteDb& db) {
  SKYQUILT_TRY_ASSIGN(auto rows, db.Prepare("SELECT name, value FROM metadata"));
  Metadata metadata;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool more, rows.Step());
    if (!more) return metadata;
    metadata[std::string(rows.ColumnText(0))] = std::string(rows.ColumnText(1));
  }
}

Result<Layout> LayOut(SqliteDb& db) {
  SKYQUILT_TRY_ASSIGN(
      auto rows,
      db.Prepare("SELECT s.zoom_level, s.tile_column, s.tile_row, s.tile_data_id, length(d.tile_data) "
                 "FROM tiles_shallow s JOIN tiles_data d ON s.tile_data_id = d.tile_data_id"));
  Layout layout;
  layout.min_zoom = geo::kMaxZoom;
  std::vector<TileRow> tiles;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool more, rows.Step());
    if (!more) break;
    const auto zoom = rows.ColumnInt64(0);
    const auto side = std::int64_t{1} << std::clamp<std::int64_t>(zoom, 0, geo::kMaxZoom);
    SKYQUILT_TRY_ASSIGN(const auto tile,
                        geo::TileId::Make(zoom, rows.ColumnInt64(1), side - 1 - rows.ColumnInt64(2)));
    tiles.push_back(
        {PmtilesNumber(tile), rows.ColumnInt64(3), static_cast<std::uint32_t>(rows.ColumnInt64(4))});
    layout.min_zoom = std::min(layout.min_zoom, tile.z());
    layout.max_zoom = std::max(layout.max_zoom, tile.z());
  }
  if (tiles.empty())
    return Error{ErrorCode::kCorrupt, "The tileset of the map holds no tiles. Stitch the flight again.", ""};
  std::sort(tiles.begin(), tiles.end(),
            [](const TileRow& a, const TileRow& b) { return a.number < b.number; });
  layout.tiles = tiles.size();
  std::unordered_map<std::int64_t, std::uint64_t> offset_of;
  for (const TileRow& tile : tiles) {
    const auto [found, is_new] = offset_of.try_emplace(tile.content, layout.bytes);
    if (is_new) {
      layout.contents.push_back(tile.content);
      layout.bytes += tile.length;
    }
    if (!layout.entries.empty()) {
      PmtilesEntry& last = layout.entries.back();
      if (last.offset == found->second && last.tile + last.run == tile.number) {
        ++last.run;
        continue;
      }
    }
    layout.entries.push_back({tile.number, found->second, tile.length, 1});
  }
  return layout;
}

std::string MetadataJson(const Metadata& metadata) {
  nlohmann::ordered_json json;
  for (const char* name : {"name", "description", "attribution", "type", "version", "generator", "fringe"}) {
    if (const auto found = metadata.find(name); found != metadata.end()) json[name] = found->second;
  }
  if (const auto found = metadata.find("tile_size"); found != metadata.end())
    json["tile_size"] = std::stoi(found->second);
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

// The numbers of a comma-separated list.
std::vector<double> Numbers(const Metadata& metadata, const char* name, std::size_t count) {
  std::vector<double> numbers;
  if (const auto found = metadata.find(name); found != metadata.end()) {
    std::istringstream text(found->second);
    text.imbue(std::locale::classic());
    double value = 0.0;
    while (numbers.size() < count && text >> value) {
      numbers.push_back(value);
      text.ignore(1);
    }
  }
  numbers.resize(count, 0.0);
  return numbers;
}

std::uint8_t TileType(const Metadata& metadata) {
  constexpr std::uint8_t kPng = 2, kJpeg = 3, kWebp = 4;
  const auto found = metadata.find("format");
  const std::string format = found != metadata.end() ? found->second : "";
  return format == "webp" ? kWebp : format == "png" ? kPng : kJpeg;
}

class HeaderBytes {
 public:
  template <typename T>
  HeaderBytes& Add(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  HeaderBytes& AddDegrees(double degrees) {
    return Add(static_cast<std::int32_t>(std::lround(degrees * 1e7)));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_ = "PMTiles";
};

std::string Header(const Layout& layout, const Metadata& metadata, const PmtilesDirectories& directories,
                   std::size_t metadata_bytes) {
  const std::uint64_t metadata_at = kPmtilesHeaderBytes + directories.root.size();
  const std::uint64_t leaves_at = metadata_at + metadata_bytes;
  const std::uint64_t tiles_at = leaves_at + directories.leaves.size();
  const std::vector<double> bounds = Numbers(metadata, "bounds", 4);
  const std::vector<double> center = Numbers(metadata, "center", 3);
  HeaderBytes header;
  header.Add(kVersion);
  header.Add<std::uint64_t>(kPmtilesHeaderBytes).Add<std::uint64_t>(directories.root.size());
  header.Add<std::uint64_t>(metadata_at).Add<std::uint64_t>(metadata_bytes);
  header.Add<std::uint64_t>(leaves_at).Add<std::uint64_t>(directories.leaves.size());
  header.Add<std::uint64_t>(tiles_at).Add<std::uint64_t>(layout.bytes);
  header.Add<std::uint64_t>(layout.tiles).Add<std::uint64_t>(layout.entries.size());
  header.Add<std::uint64_t>(layout.contents.size());
  header.Add<std::uint8_t>(1);  // clustered
  header.Add(kGzip).Add(kUncompressed).Add(TileType(metadata));
  header.Add(static_cast<std::uint8_t>(layout.min_zoom)).Add(static_cast<std::uint8_t>(layout.max_zoom));
  for (const double bound : bounds) header.AddDegrees(bound);
  header.Add(static_cast<std::uint8_t>(center[2])).AddDegrees(center[0]).AddDegrees(center[1]);
  return header.bytes();
}

}  // namespace

Result<void> WritePmtiles(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                          Progress& progress) {
  SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
  SKYQUILT_TRY_ASSIGN(const Metadata metadata, ReadMetadata(db));
  SKYQUILT_TRY_ASSIGN(const Layout layout, LayOut(db));
  const PmtilesDirectories directories = MakePmtilesDirectories(layout.entries);
  const std::string about = Gzip(MetadataJson(metadata));
  SKYQUILT_TRY_ASSIGN(auto file, StreamFile::Create(path));
  file->Write(Header(layout, metadata, directories, about.size()));
  file->Write(directories.root);
  file->Write(about);
  file->Write(directories.leaves);
  SKYQUILT_TRY_ASSIGN(auto load, db.Prepare("SELECT tile_data FROM tiles_data WHERE tile_data_id = ?1"));
  for (std::size_t i = 0; i < layout.contents.size(); ++i) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
    SKYQUILT_TRY(load.Bind(1, layout.contents[i]).Step());
    const auto blob = load.ColumnBlob(0);
    file->Write({reinterpret_cast<const char*>(blob.data()), blob.size()});
    load.Reset();
    progress.Report(static_cast<double>(i + 1) / static_cast<double>(layout.contents.size()),
                    "writing PMTiles");
  }
  return file->Publish();
}

}  // namespace skyquilt::storage
