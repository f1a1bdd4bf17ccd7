#include "storage/exports/pmtiles_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/image/picture_format.h"
#include "storage/exports/stored_tiles.h"
#include "storage/files/publish_file.h"
#include "storage/pmtiles/pmtiles_archive.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the file is written in the byte order of the machine");

constexpr std::uint8_t kVersion = 3, kGzip = 2, kUncompressed = 1;

struct TileRow {
  std::uint64_t number = 0;
  std::int64_t content = 0;  // tile_data_id
  std::uint32_t length = 0;
};

struct Layout {
  std::vector<PmtilesEntry> entries;
  std::vector<StreamedPiece> contents;  // in the order of the file, counted from the first tile's byte
  std::uint64_t tiles = 0;
  std::uint64_t bytes = 0;
  int min_zoom = 0, max_zoom = 0;
};

Result<Layout> LayOut(SqliteDb& db) {
  SKYQUILT_TRY_ASSIGN(const std::vector<TableTile> table, ReadTileTable(db));
  Layout layout;
  // By zooms first.
  layout.min_zoom = table.front().tile.z();
  layout.max_zoom = table.back().tile.z();
  std::vector<TileRow> tiles;
  tiles.reserve(table.size());
  for (const TableTile& tile : table)
    tiles.push_back({PmtilesNumber(tile.tile), tile.content_id, tile.bytes});
  std::sort(tiles.begin(), tiles.end(),
            [](const TileRow& a, const TileRow& b) { return a.number < b.number; });
  layout.tiles = tiles.size();
  std::unordered_map<std::int64_t, std::uint64_t> offset_of;
  offset_of.reserve(tiles.size());
  for (const TileRow& tile : tiles) {
    const auto [found, is_new] = offset_of.try_emplace(tile.content, layout.bytes);
    if (is_new) {
      layout.contents.push_back({layout.bytes, tile.content});
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

std::string MetadataJson(const TilesetFacts& metadata) {
  nlohmann::ordered_json json;
  for (const char* name : {"name", "description", "attribution", "type", "version", "generator", "fringe"}) {
    if (const auto found = metadata.find(name); found != metadata.end()) json[name] = found->second;
  }
  if (metadata.contains("tile_size")) json["tile_size"] = TilesetNumber(metadata, "tile_size", 256);
  return JsonText(json);
}

// The numbers of a comma-separated list.
std::vector<double> Numbers(const TilesetFacts& metadata, const char* name, std::size_t count) {
  std::vector<double> numbers;
  std::istringstream text(TilesetText(metadata, name));
  text.imbue(std::locale::classic());
  double value = 0.0;
  while (numbers.size() < count && text >> value) {
    numbers.push_back(value);
    text.ignore(1);
  }
  numbers.resize(count, 0.0);
  return numbers;
}

std::uint8_t TileType(const TilesetFacts& metadata) {
  const auto format = image::PictureFormatNamed(TilesetText(metadata, "format"));
  return static_cast<std::uint8_t>(image::PmtilesTypeOf(format.value_or(image::PictureFormat::kJpeg)));
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

std::string Header(const Layout& layout, const TilesetFacts& metadata, const PmtilesDirectories& directories,
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

class StreamedPmtiles final : public StreamedFile {
 public:
  StreamedPmtiles(std::string head, std::vector<StreamedPiece> pieces, std::uint64_t length)
      : StreamedFile(std::move(head), std::move(pieces), length) {}

 protected:
  Result<std::string> Make(std::int64_t content, std::uint64_t /*bytes*/, MapTiles& tiles) const override {
    return tiles.Load({static_cast<std::uint64_t>(content), std::nullopt});
  }
};

}  // namespace

Result<std::shared_ptr<const StreamedFile>> LayOutPmtiles(SqliteDb& mbtiles, const TilesetFacts& metadata) {
  SKYQUILT_TRY_ASSIGN(Layout layout, LayOut(mbtiles));
  const PmtilesDirectories directories = MakePmtilesDirectories(layout.entries);
  const std::string about = Gzip(MetadataJson(metadata));
  std::string head = Header(layout, metadata, directories, about.size());
  head += directories.root;
  head += about;
  head += directories.leaves;
  for (StreamedPiece& piece : layout.contents) piece.offset += head.size();
  const std::uint64_t length = head.size() + layout.bytes;
  return std::shared_ptr<const StreamedFile>(
      std::make_shared<const StreamedPmtiles>(std::move(head), std::move(layout.contents), length));
}

Result<void> WritePmtiles(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                          Progress& progress) {
  SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
  SKYQUILT_TRY_ASSIGN(const auto tiles, MbtilesReader::Open(mbtiles));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const StreamedFile> streamed,
                      LayOutPmtiles(db, tiles->metadata()));
  SKYQUILT_TRY_ASSIGN(auto file, StreamFile::Create(path));
  file->Write(streamed->head());
  for (std::size_t i = 0; i < streamed->PieceCount(); ++i) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
    SKYQUILT_TRY_ASSIGN(const std::string bytes, streamed->MakePiece(i, *tiles));
    file->Write(bytes);
    progress.Report(static_cast<double>(i + 1) / static_cast<double>(streamed->PieceCount()),
                    "writing PMTiles");
  }
  return file->Publish();
}

}  // namespace skyquilt::storage
