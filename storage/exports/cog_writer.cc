#include "storage/exports/cog_writer.h"

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "storage/exports/streamed/cog_cells.h"
#include "storage/files/stream_file.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {
namespace {

// Where its own bytes begin.
std::uint64_t WriteBlock(StreamFile& file, std::string_view block) {
  const std::uint64_t at = file.position() + kBlockSizeBytes;
  std::string framed;
  AppendBlock(block, framed);
  file.Write(framed);
  return at;
}

}  // namespace

int TileSizeOf(const TilesetFacts& metadata) { return TilesetNumber(metadata, "tile_size", 256); }

TiffTiles TiffTilesOf(const TilesetFacts& metadata) {
  return EncodingOf(metadata) == image::TileEncoding::kWebp ? TiffTiles::kWebp : TiffTiles::kJpeg;
}

GridAlignment GridAlignmentOf(TiffTiles tiles) {
  return tiles == TiffTiles::kWebp ? GridAlignment::kAllLevels : GridAlignment::kFineLevels;
}

Result<void> WriteCog(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                      const CogOptions& options, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(auto tiles, MbtilesReader::Open(mbtiles));
  const int tile_size_px = TileSizeOf(tiles->metadata());
  const TiffTiles kind = TiffTilesOf(tiles->metadata());
  std::vector<GridLevel> grid;
  {
    SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
    SKYQUILT_TRY_ASSIGN(grid, GridOf(db, tile_size_px, GridAlignmentOf(kind)));
  }
  std::error_code unknown_size;
  std::uint64_t expected_bytes = std::filesystem::file_size(mbtiles, unknown_size);
  std::int64_t cells = 0;
  for (const GridLevel& level : grid) cells += level.CellCount();
  expected_bytes += static_cast<std::uint64_t>(cells) * 64;

  TiffHead head(grid, tile_size_px, kind, expected_bytes > kClassicTiffLimitBytes);
  SKYQUILT_TRY_ASSIGN(auto file, StreamFile::Create(path));
  file->Write(head.bytes());
  const CogCells work(kind, tile_size_px, options.jpeg_quality);
  std::int64_t done = 0;
  // The smallest overview first: a reader that fetches the file's beginning has a picture at once.
  for (std::size_t level = grid.size(); level-- > 0;) {
    const GridLevel& cells_of = grid[level];
    std::optional<Error> failure;
    const std::size_t window = 4 * static_cast<std::size_t>(ThreadCount(options.threads)) + 4;
    ParallelOrdered<Result<CogCell>>(
        static_cast<std::size_t>(cells_of.CellCount()), options.threads, window,
        [&](std::size_t cell) -> Result<CogCell> {
          if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
          return work.Make(cells_of, static_cast<std::int64_t>(cell), *tiles);
        },
        [&](std::size_t cell, Result<CogCell>&& ready) {
          if (failure) return;
          if (!ready) {
            failure = ready.error();
            return;
          }
          ++done;
          if (ready->image.empty()) return;
          const auto number = static_cast<std::int64_t>(cell);
          head.SetTile(level, number, WriteBlock(*file, ready->image), ready->image.size());
          if (kind == TiffTiles::kJpeg)
            head.SetMask(level, number, WriteBlock(*file, ready->mask), ready->mask.size());
          progress.Report(static_cast<double>(done) / static_cast<double>(cells), "writing GeoTIFF");
        });
    if (failure) return *failure;
  }
  file->WriteAt(0, head.bytes());
  return file->Publish();
}

}  // namespace skyquilt::storage
