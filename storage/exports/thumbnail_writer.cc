#include "storage/exports/thumbnail_writer.h"

#include <cpl_error.h>
#include <gdal_priv.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/try.h"
#include "core/image/png_encoder.h"
#include "core/image/shrink/shrink_picture.h"
#include "storage/exports/cog_writer.h"
#include "storage/exports/streamed/cog_cells.h"
#include "storage/files/publish_file.h"
#include "storage/rasters/gdal_steps.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {
namespace {

// The smallest overview that has `longer_side_px` pixels, or the map itself.
const GridLevel& LevelFor(const std::vector<GridLevel>& grid, int longer_side_px) {
  std::size_t level = grid.size() - 1;
  while (level > 0 && std::max(grid[level].width_px, grid[level].height_px) < longer_side_px) --level;
  return grid[level];
}

// Of the picture that all cells are put into: a map without coarse tiles has no overview that is small.
constexpr std::int64_t kMaxWholePx = std::int64_t{1} << 24;

// By what both sides of each cell are divided before.
int ShrinkOf(const GridLevel& level, int tile_px) {
  int shrink = 1;
  while (tile_px % (2 * shrink) == 0 && level.width_px / shrink * (level.height_px / shrink) > kMaxWholePx)
    shrink *= 2;
  return shrink;
}

}  // namespace

Result<void> WriteTilesThumbnail(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                                 int longer_side_px) {
  SKYQUILT_TRY_ASSIGN(const auto tiles, MbtilesReader::Open(mbtiles));
  SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
  SKYQUILT_TRY_ASSIGN(const CogLayout layout, CogLayoutOf(db, tiles->metadata()));
  const int tile_px = layout.tile_size_px;
  const GridLevel& level = LevelFor(layout.grid, longer_side_px);
  SKYQUILT_TRY(CheckCells(level));
  const int shrink = ShrinkOf(level, tile_px), cell_px = tile_px / shrink;
  const CogCells cells(layout.tiles, tile_px, CogOptions().jpeg_quality);
  const auto width_px = static_cast<int>((level.width_px + shrink - 1) / shrink),
             height_px = static_cast<int>((level.height_px + shrink - 1) / shrink);
  image::RgbaImage whole = image::RgbaImage::Transparent(width_px, height_px);
  for (std::int64_t cell = 0; cell < level.CellCount(); ++cell) {
    SKYQUILT_TRY_ASSIGN(std::optional<image::RgbaImage> pixels, cells.PixelsOf(level, cell, *tiles));
    if (!pixels) continue;
    const image::RgbaImage small = image::ShrinkPicture(*std::move(pixels), cell_px);
    const auto left = static_cast<int>(cell % level.columns) * cell_px,
               top = static_cast<int>(cell / level.columns) * cell_px;
    const std::size_t row_bytes = 4 * static_cast<std::size_t>(std::min(cell_px, width_px - left));
    for (int y = 0; y < std::min(cell_px, height_px - top); ++y)
      std::memcpy(whole.Pixel(left, top + y), small.Pixel(0, y), row_bytes);
  }
  const std::vector<std::uint8_t> png =
      image::EncodeWholePng(image::ShrinkPicture(std::move(whole), longer_side_px));
  return WriteFileAtomically(path, {reinterpret_cast<const char*>(png.data()), png.size()});
}

Result<void> WriteThumbnail(const std::filesystem::path& cog, const std::filesystem::path& path,
                            int longer_side_px) {
  RegisterGdalOnce();
  CPLErrorReset();
  const auto failed = [] {
    const std::string detail = CPLGetLastErrorMsg();
    return Error{ErrorCode::kIo, "The thumbnail of the map cannot be written: " + detail + ".", detail};
  };
  const std::unique_ptr<GDALDataset> map(GDALDataset::Open(cog.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!map) return failed();
  const int longer_px = std::max(map->GetRasterXSize(), map->GetRasterYSize());
  const double shrink = std::min(1.0, static_cast<double>(longer_side_px) / longer_px);
  const auto side = [&](int side_px) {
    return std::to_string(std::max(1, static_cast<int>(side_px * shrink)));
  };
  CPLStringList words;
  AddGdalWords(words, {"-of", "PNG", "-r", "average", "-outsize", side(map->GetRasterXSize()),
                       side(map->GetRasterYSize())});
  if (map->GetRasterCount() == 3) AddGdalWords(words, {"-b", "1", "-b", "2", "-b", "3", "-b", "mask"});
  const TemporaryFile made(path, ".tmp");
  if (!TranslateRaster(*map, made.c_str(), words, nullptr)) return failed();
  return PublishFile(made.path(), path);
}

}  // namespace skyquilt::storage
