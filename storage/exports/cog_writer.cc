#include "storage/exports/cog_writer.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "core/image/picture_codec.h"
#include "storage/exports/fringe_tile.h"
#include "storage/exports/tiff_head.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/stream_file.h"

namespace skyquilt::storage {
namespace {

// Beyond this a classic TIFF's 32-bit places might not reach.
constexpr std::uint64_t kClassicLimitBytes = std::uint64_t{3500} << 20;

struct ReadyTile {
  std::optional<Error> error;
  std::string image;  // empty: no tile here
  std::string mask;
};

bool IsJpeg(std::string_view bytes) { return bytes.starts_with("\xff\xd8\xff"); }
bool IsWebp(std::string_view bytes) { return bytes.starts_with("RIFF"); }

std::string Deflated(const std::vector<std::uint8_t>& bits) {
  uLongf size = compressBound(bits.size());
  std::string out(size, '\0');
  const int code = compress2(reinterpret_cast<Bytef*>(out.data()), &size, bits.data(), bits.size(), 6);
  SKYQUILT_CHECK(code == Z_OK, "a buffer of the asked size did not hold the mask");
  out.resize(size);
  return out;
}

class Export {
 public:
  Export(MbtilesReader& tiles, TiffTiles kind, int tile_size_px, const CogOptions& options)
      : tiles_(tiles), kind_(kind), tile_size_px_(tile_size_px), options_(options) {
    const auto row_bytes = (static_cast<std::size_t>(tile_size_px) + 7) / 8;
    full_mask_ =
        Deflated(std::vector<std::uint8_t>(row_bytes * static_cast<std::size_t>(tile_size_px), 0xff));
  }

  ReadyTile Prepare(const GridLevel& level, std::int64_t cell) const {
    return level.IsAligned() ? Copied(*level.TileOf(cell)) : Composed(level, cell);
  }

 private:
  // The tileset's own tile.
  ReadyTile Copied(const geo::TileId& tile) const {
    ReadyTile ready;
    Result<std::string> bytes = Load(tile);
    if (!bytes) return Failed(bytes.error());
    if (bytes->empty()) return ready;
    if (kind_ == TiffTiles::kWebp) {
      if (IsWebp(*bytes)) {
        ready.image = *std::move(bytes);
        return ready;
      }
      const Result<image::RgbaImage> canvas = DecodeTile(*bytes, tile_size_px_);
      if (!canvas) return Failed(canvas.error());
      const auto webp = image::EncodeWebp(image::RowsOf(*canvas), static_cast<float>(options_.jpeg_quality));
      ready.image.assign(webp.begin(), webp.end());
    } else if (IsJpeg(*bytes)) {
      ready.image = *std::move(bytes);
      ready.mask = full_mask_;
    } else {
      Result<image::RgbaImage> canvas = DecodeTile(*bytes, tile_size_px_);
      if (!canvas) return Failed(canvas.error());
      ready = Encoded(*std::move(canvas));
    }
    return ready;
  }

  // A cell put together from the up to four tiles that it lies over.
  ReadyTile Composed(const GridLevel& level, std::int64_t cell) const {
    image::RgbaImage composed = image::RgbaImage::Transparent(tile_size_px_, tile_size_px_);
    for (int south = 0; south <= (level.shift_y_px > 0 ? 1 : 0); ++south) {
      for (int east = 0; east <= (level.shift_x_px > 0 ? 1 : 0); ++east) {
        const std::optional<geo::TileId> tile = level.TileOf(cell, east, south);
        if (!tile) continue;
        Result<std::string> bytes = Load(*tile);
        if (!bytes) return Failed(bytes.error());
        if (bytes->empty()) continue;
        Result<image::RgbaImage> canvas = DecodeTile(*bytes, tile_size_px_);
        if (!canvas) return Failed(canvas.error());
        // The tile's corner in the cell.
        const int left = east * tile_size_px_ - level.shift_x_px,
                  top = south * tile_size_px_ - level.shift_y_px;
        const int from_x = std::max(0, left), to_x = std::min(tile_size_px_, left + tile_size_px_);
        for (int y = std::max(0, top); y < std::min(tile_size_px_, top + tile_size_px_); ++y) {
          std::memcpy(composed.Pixel(from_x, y), canvas->Pixel(from_x - left, y - top),
                      4 * static_cast<std::size_t>(to_x - from_x));
        }
      }
    }
    return Encoded(std::move(composed));
  }

  ReadyTile Encoded(image::RgbaImage canvas) const {
    ReadyTile ready;
    FringeTile fringe = SplitAlpha(std::move(canvas), options_.jpeg_quality);
    if (fringe.is_empty) return ready;
    ready.image = std::move(fringe.jpeg);
    ready.mask = Deflated(fringe.mask_bits);
    return ready;
  }

  // Empty: the tileset has no such tile.
  Result<std::string> Load(const geo::TileId& tile) const {
    SKYQUILT_TRY_ASSIGN(std::optional<FoundTile> found, tiles_.Find(tile));
    if (!found) return std::string();
    return tiles_.Load(*std::move(found));
  }

  static ReadyTile Failed(Error error) {
    ReadyTile ready;
    ready.error = std::move(error);
    return ready;
  }

  MbtilesReader& tiles_;
  const TiffTiles kind_;
  const int tile_size_px_;
  const CogOptions& options_;
  std::string full_mask_;
};

// One block as the structure note promises it: its size before it, its last four bytes once more behind it.
std::uint64_t WriteBlock(StreamFile& file, std::string_view block) {
  const auto size = static_cast<std::uint32_t>(block.size());
  file.Write({reinterpret_cast<const char*>(&size), 4});
  const std::uint64_t at = file.position();
  file.Write(block);
  file.Write(block.substr(block.size() - 4));
  return at;
}

int TileSizeOf(const MbtilesReader& tiles) {
  const auto found = tiles.metadata().find("tile_size");
  int size_px = 256;
  if (found != tiles.metadata().end()) {
    std::from_chars(found->second.data(), found->second.data() + found->second.size(), size_px);
  }
  return size_px;
}

}  // namespace

Result<void> WriteCog(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                      const CogOptions& options, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(auto tiles, MbtilesReader::Open(mbtiles));
  const int tile_size_px = TileSizeOf(*tiles);
  const bool is_webp = EncodingOf(tiles->metadata()) == image::TileEncoding::kWebp;
  const TiffTiles kind = is_webp ? TiffTiles::kWebp : TiffTiles::kJpeg;
  std::vector<GridLevel> grid;
  {
    SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
    SKYQUILT_TRY_ASSIGN(auto made, GridOf(db, tile_size_px,
                                          is_webp ? GridAlignment::kAllLevels : GridAlignment::kFineLevels));
    grid = std::move(made);
  }
  std::error_code unknown_size;
  std::uint64_t expected_bytes = std::filesystem::file_size(mbtiles, unknown_size);
  std::int64_t cells = 0;
  for (const GridLevel& level : grid) cells += level.CellCount();
  expected_bytes += static_cast<std::uint64_t>(cells) * 64;

  TiffHead head(grid, tile_size_px, kind, expected_bytes > kClassicLimitBytes);
  SKYQUILT_TRY_ASSIGN(auto file, StreamFile::Create(path));
  file->Write(head.bytes());
  const Export work(*tiles, kind, tile_size_px, options);
  std::int64_t done = 0;
  // The smallest overview first: a reader that fetches the file's beginning has a picture at once.
  for (std::size_t level = grid.size(); level-- > 0;) {
    const GridLevel& cells_of = grid[level];
    std::optional<Error> failure;
    const std::size_t window = 4 * static_cast<std::size_t>(ThreadCount(options.threads)) + 4;
    ParallelOrdered<ReadyTile>(
        static_cast<std::size_t>(cells_of.CellCount()), options.threads, window,
        [&](std::size_t cell) {
          if (progress.IsCancelled())
            return ReadyTile{Error{ErrorCode::kCancelled, "The job was cancelled.", ""}, {}, {}};
          return work.Prepare(cells_of, static_cast<std::int64_t>(cell));
        },
        [&](std::size_t cell, ReadyTile&& ready) {
          if (failure) return;
          if (ready.error) {
            failure = std::move(ready.error);
            return;
          }
          ++done;
          if (ready.image.empty()) return;
          const auto number = static_cast<std::int64_t>(cell);
          head.SetTile(level, number, WriteBlock(*file, ready.image), ready.image.size());
          if (kind == TiffTiles::kJpeg)
            head.SetMask(level, number, WriteBlock(*file, ready.mask), ready.mask.size());
          progress.Report(static_cast<double>(done) / static_cast<double>(cells), "writing GeoTIFF");
        });
    if (failure) return *failure;
  }
  file->WriteAt(0, head.bytes());
  return file->Publish();
}

}  // namespace skyquilt::storage
