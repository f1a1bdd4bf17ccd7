#include "storage/exports/cog_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "tests/storage/painted_tileset.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

using test::PaintedTile;
using test::PaintedTileset;

struct OpenedCog {
  test::TemporaryFolder folder;
  std::filesystem::path mbtiles, tif;
  std::unique_ptr<GDALDataset> dataset;
};

std::unique_ptr<OpenedCog> WriteAndOpen(const PaintedTileset& tileset, int threads = 2) {
  auto opened = std::make_unique<OpenedCog>();
  opened->mbtiles = opened->folder.path() / "map.mbtiles";
  opened->tif = opened->folder.path() / "map.tif";
  WritePaintedTileset(opened->mbtiles, tileset);
  SilentProgress progress;
  const Result<void> written = WriteCog(opened->mbtiles, opened->tif, {85, threads}, progress);
  EXPECT_TRUE(written.ok()) << (written ? "" : written.error().message);
  GDALAllRegister();
  opened->dataset = test::OpenByGdal(opened->tif);
  return opened;
}

// Of tiles that were put one by one.
std::unique_ptr<GDALDataset> PublishAndOpen(MbtilesWriter& writer, int zoom,
                                            const std::filesystem::path& mbtiles) {
  TilesetMetadata metadata;
  metadata.min_zoom = metadata.max_zoom = zoom;
  const std::filesystem::path tif = mbtiles.string() + ".tif";
  SilentProgress progress;
  EXPECT_TRUE(writer.Publish(metadata));
  EXPECT_TRUE(WriteCog(mbtiles, tif, {}, progress));
  GDALAllRegister();
  return test::OpenByGdal(tif);
}

// Blue, green, red: what the stored tile decodes to.
cv::Mat DecodedTile(MbtilesReader& tiles, const geo::TileId& id) {
  auto found = tiles.Find(id);
  if (!found || !*found) return {};
  const auto bytes = tiles.Load(**found);
  return cv::imdecode(std::vector<std::uint8_t>(bytes->begin(), bytes->end()), cv::IMREAD_UNCHANGED);
}

struct Window {
  int left = 0, top = 0, right = 0, bottom = 0;
  int Width() const { return right - left; }
};

std::vector<std::uint8_t> ReadBand(GDALRasterBand* band, const Window& window) {
  return test::PixelsOf(*band, window.left, window.top, window.Width(), window.bottom - window.top);
}

// Compares one level with every tile of the tileset that lies over it: copied tiles to the rounding of two
// JPEG decoders, fringe and moved tiles to the mean loss of JPEG, the mask to the alpha exactly.
void ExpectLevelShowsTiles(OpenedCog& cog, const PaintedTileset& tileset, int level, int origin_column,
                           int origin_row) {
  const int side = tileset.tile_size_px;
  const int left_px = origin_column * side >> level, top_px = origin_row * side >> level;
  const bool is_copied = left_px % side == 0 && top_px % side == 0;
  auto tiles = *MbtilesReader::Open(cog.mbtiles);
  std::array<GDALRasterBand*, 3> bands{};
  for (int c = 0; c < 3; ++c) {
    GDALRasterBand* band = cog.dataset->GetRasterBand(c + 1);
    bands[static_cast<std::size_t>(c)] = level == 0 ? band : band->GetOverview(level - 1);
  }
  GDALRasterBand* mask = bands[0]->GetMaskBand();
  const int width = bands[0]->GetXSize(), height = bands[0]->GetYSize();
  int compared = 0;
  double encoded_again = 0.0;  // differences, summed
  std::int64_t encoded_again_count = 0;
  for (int row = top_px / side; row * side < top_px + height; ++row) {
    for (int column = left_px / side; column * side < left_px + width; ++column) {
      const cv::Mat stored = DecodedTile(*tiles, *geo::TileId::Make(tileset.zoom - level, column, row));
      const int left = column * side - left_px, top = row * side - top_px;
      const Window window{std::max(0, left), std::max(0, top), std::min(width, left + side),
                          std::min(height, top + side)};
      const auto shown = ReadBand(mask, window);
      if (stored.empty()) {
        for (const std::uint8_t value : shown)
          ASSERT_EQ(value, 0) << column << " " << row << " level " << level;
        continue;
      }
      ++compared;
      const int channels = stored.channels();
      int wrong_masks = 0, largest_of_copied = 0;  // of some millions of pixels: not each by a macro
      for (int c = 0; c < 3; ++c) {
        const auto values = ReadBand(bands[static_cast<std::size_t>(c)], window);
        for (std::size_t i = 0; i < values.size(); ++i) {
          const int x = window.left - left + static_cast<int>(i) % window.Width();
          const int y = window.top - top + static_cast<int>(i) / window.Width();
          const std::uint8_t* pixel = stored.ptr(y) + static_cast<std::ptrdiff_t>(x) * channels;
          const bool is_covered = channels == 3 || pixel[3] >= 128;
          wrong_masks += shown[i] != (is_covered ? 255 : 0) ? 1 : 0;
          if (!is_covered) continue;
          const int difference = std::abs(values[i] - pixel[2 - c]);
          if (channels == 3 && is_copied) {
            largest_of_copied = std::max(largest_of_copied, difference);
          } else {
            encoded_again += difference;
            ++encoded_again_count;
          }
        }
      }
      ASSERT_EQ(wrong_masks, 0) << column << " " << row << " level " << level;
      ASSERT_LE(largest_of_copied, 4) << column << " " << row;
    }
  }
  EXPECT_GT(compared, 0);
  EXPECT_LT(encoded_again / static_cast<double>(std::max<std::int64_t>(1, encoded_again_count)),
            8.0);  // a pixel of shift is 20
}

TEST(WriteCog, ShowsTheTilesetsOwnTilesAtEveryLevel) {
  const PaintedTileset tileset{18, 256, 1001, 2002, 7, 6};
  const auto cog = WriteAndOpen(tileset);
  // A small map keeps its corner; its overviews begin inside tiles.
  const int levels = cog->dataset->GetRasterBand(1)->GetOverviewCount();
  ASSERT_EQ(levels, 2);
  for (int level = 0; level <= levels; ++level) ExpectLevelShowsTiles(*cog, tileset, level, 1001, 2002);
}

TEST(WriteCog, MovesTheCornerOfALargeMapToATileOfItsFinerOverviews) {
  const PaintedTileset tileset{12, 256, 1003, 2003, 33, 33};
  const auto cog = WriteAndOpen(tileset);
  const int levels = cog->dataset->GetRasterBand(1)->GetOverviewCount();
  ASSERT_EQ(levels, 4);
  EXPECT_EQ(cog->dataset->GetRasterXSize(), 36 * 256);
  for (int level = 0; level <= levels; ++level) ExpectLevelShowsTiles(*cog, tileset, level, 1000, 2000);
}

TEST(WriteCog, LiesWhereTheTilesLie) {
  const PaintedTileset tileset{18, 512, 1001, 2002, 7, 6};
  const auto cog = WriteAndOpen(tileset);
  const auto transform = test::TransformOf(*cog->dataset);
  const geo::Bounds2 corner = geo::TileId::Make(18, 1001, 2002)->BoundsInMerc();
  EXPECT_NEAR(transform[0], corner.min.x(), 1e-6);
  EXPECT_NEAR(transform[3], corner.max.y(), 1e-6);
  EXPECT_DOUBLE_EQ(transform[1], geo::PixelSizeInMercM(18, 512));
  const OGRSpatialReference* reference = cog->dataset->GetSpatialRef();
  ASSERT_NE(reference, nullptr);
  EXPECT_STREQ(reference->GetAuthorityCode(nullptr), "3857");
}

// Maps from before, and those of `--format jpeg-png`.
TEST(WriteCog, ShowsTilesWhoseFringeIsPng) {
  const PaintedTileset tileset{18, 256, 1001, 2002, 7, 6, image::TileEncoding::kJpegPng};
  const auto cog = WriteAndOpen(tileset);
  for (int level = 0; level <= cog->dataset->GetRasterBand(1)->GetOverviewCount(); ++level)
    ExpectLevelShowsTiles(*cog, tileset, level, 1001, 2002);
}

TEST(WriteCog, MakesWebpOfWhatIsNotAmongTilesThatAre) {
  test::TemporaryFolder folder;
  const std::filesystem::path mbtiles = folder.path() / "map.mbtiles";
  const PaintedTileset painted{18, 256, 64, 64, 2, 1};
  auto writer = *MbtilesWriter::Create(mbtiles);
  auto opaque = image::RgbaImage::Transparent(256, 256);
  std::fill(opaque.rgba.begin(), opaque.rgba.end(), std::uint8_t{255});
  const image::RgbaImage fringe = PaintedTile(painted, 1, 0);
  const auto put = [&](int column, const image::RgbaImage& tile, image::TileEncoding encoding) {
    const auto encoded = pyramid::EncodeTile(tile, {encoding, 90});
    ASSERT_TRUE(writer->Put(*geo::TileId::Make(8, column, 100), encoded->format, encoded->bytes));
  };
  put(100, opaque, image::TileEncoding::kWebp);
  put(101, fringe, image::TileEncoding::kJpegPng);
  const auto cog = PublishAndOpen(*writer, 8, mbtiles);
  ASSERT_EQ(cog->GetRasterCount(), 4);
  const auto alpha = ReadBand(cog->GetRasterBand(4), {256, 0, 512, 256});
  for (std::size_t i = 0; i < alpha.size(); ++i) ASSERT_EQ(alpha[i], fringe.rgba[4 * i + 3]);
}

TEST(WriteCog, CopiesTheBytesOfOpaqueTiles) {
  const PaintedTileset tileset{16, 256, 64, 64, 8, 8};
  const auto cog = WriteAndOpen(tileset);
  auto tiles = *MbtilesReader::Open(cog->mbtiles);
  auto found = *tiles->Find(*geo::TileId::Make(16, 68, 68));
  ASSERT_TRUE(found);
  EXPECT_NE(test::BytesOf(cog->tif).find(*tiles->Load(*found)), std::string::npos);
}

TEST(WriteCog, KeepsWebpTilesWithTheirAlpha) {
  const PaintedTileset tileset{18, 256, 1000, 2000, 4, 4, image::TileEncoding::kWebp, 90};
  const auto cog = WriteAndOpen(tileset);
  ASSERT_EQ(cog->dataset->GetRasterCount(), 4);
  const image::RgbaImage truth = PaintedTile(tileset, 0, 1);
  const auto alpha = ReadBand(cog->dataset->GetRasterBand(4), {0, 256, 256, 512});
  for (int i = 0; i < 256 * 256; ++i) {
    ASSERT_EQ(alpha[static_cast<std::size_t>(i)], truth.rgba[static_cast<std::size_t>(i) * 4 + 3]);
  }
}

TEST(WriteCog, IsTheSameWithAnyNumberOfThreads) {
  const PaintedTileset tileset{18, 256, 1001, 2002, 5, 5};
  EXPECT_EQ(test::BytesOf(WriteAndOpen(tileset, 1)->tif), test::BytesOf(WriteAndOpen(tileset, 3)->tif));
}

// What the tileset holds once stands in the GeoTIFF once for each of its places.
TEST(WriteCog, HasPlacesOf64BitsWhereOnePictureOfManyTilesTakesMoreThan4GiB) {
  CogLayout layout;
  GridLevel level;
  level.zoom = 20;
  level.columns = level.rows = 300;
  level.width_px = level.height_px = 300 * 256;
  layout.grid = {level};
  const TableTile tile{*geo::TileId::Make(20, 7, 7), 1, 50'000, image::PictureFormat::kJpeg};
  const std::uint64_t bytes = MostCogBytes(layout, std::vector<TableTile>(300 * 300, tile));
  EXPECT_GT(bytes, std::uint64_t{300} * 300 * 50'000);
  EXPECT_EQ(TiffHead(layout.grid, 256, TiffTiles::kJpeg, bytes).bytes()[2], 43);
  EXPECT_EQ(TiffHead(layout.grid, 256, TiffTiles::kJpeg, 50'000).bytes()[2], 42);
}

TEST(WriteCog, TakesNoMoreThanItIsLaidOutFor) {
  const auto cog = WriteAndOpen({18, 256, 1001, 2002, 7, 6});
  const auto tiles = *MbtilesReader::Open(cog->mbtiles);
  auto db = *SqliteDb::Open(cog->mbtiles, OpenMode::kReadOnlyImmutable);
  EXPECT_LE(std::filesystem::file_size(cog->tif),
            MostCogBytes(*CogLayoutOf(db, tiles->metadata()), *ReadTileTable(db)));
}

TEST(WriteCog, PassesGdalsValidator) {
  constexpr const char* kModule = "osgeo_utils.samples.validate_cloud_optimized_geotiff";
  const std::string python = "/usr/bin/python3 -m " + std::string(kModule);
  if (std::system((python + " --help > /dev/null 2>&1; [ $? -ne 1 ]").c_str()) != 0) {
    GTEST_SKIP() << "python3-gdal is not installed";
  }
  for (const PaintedTileset& tileset :
       {PaintedTileset{18, 256, 1001, 2002, 7, 6}, PaintedTileset{18, 512, 99, 70, 3, 9},
        PaintedTileset{18, 256, 1000, 2000, 1, 1},
        PaintedTileset{18, 256, 9, 2000, 4, 4, image::TileEncoding::kWebp, 80}}) {
    const auto cog = WriteAndOpen(tileset);
    cog->dataset.reset();
    EXPECT_EQ(std::system((python + " -q --full-check=yes " + cog->tif.string()).c_str()), 0);
  }
}

TEST(WriteCog, StaysInOnePieceAcrossTheDateLine) {
  test::TemporaryFolder folder;
  const std::filesystem::path mbtiles = folder.path() / "map.mbtiles";
  auto writer = *MbtilesWriter::Create(mbtiles);
  for (int column = 0; column < 4; ++column) {
    auto image = image::RgbaImage::Transparent(256, 256);
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
      image.rgba[i] = i % 4 == 3 ? 255 : static_cast<std::uint8_t>(60 * column);
    const auto encoded = pyramid::EncodeTile(image, {});
    ASSERT_TRUE(
        writer->Put(*geo::TileId::Make(8, (254 + column) % 256, 100), encoded->format, encoded->bytes));
  }
  const auto cog = PublishAndOpen(*writer, 8, mbtiles);
  ASSERT_EQ(cog->GetRasterXSize(), 4 * 256);
  for (int column = 0; column < 4; ++column) {
    EXPECT_NEAR(ReadBand(cog->GetRasterBand(1), {256 * column, 0, 256 * column + 256, 256})[1000],
                60 * column, 2);
  }
}

// As of a map of the world with two towns: 3.6e9 cells, whose places alone take 57 GB.
TEST(WriteCog, RefusesTilesThatLieTooFarApart) {
  test::TemporaryFolder folder;
  const std::filesystem::path mbtiles = folder.path() / "map.mbtiles";
  auto writer = *MbtilesWriter::Create(mbtiles);
  const auto tile = pyramid::EncodeTile(PaintedTile({16, 256, 0, 0, 3, 3}, 1, 1), {});
  for (const int at : {100, 60'000})
    ASSERT_TRUE(writer->Put(*geo::TileId::Make(17, at, at), tile->format, tile->bytes));
  ASSERT_TRUE(writer->Publish({}));
  auto db = *SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable);
  const auto tiles = *MbtilesReader::Open(mbtiles);
  const auto laid_out = LayOutCog(db, tiles->metadata());
  ASSERT_FALSE(laid_out);
  EXPECT_EQ(laid_out.error().code, ErrorCode::kTooLarge);
  SilentProgress progress;
  EXPECT_EQ(WriteCog(mbtiles, folder.path() / "map.tif", {}, progress).error().code, ErrorCode::kTooLarge);
}

TEST(WriteCog, LeavesNothingBehindWhenCancelled) {
  class Cancelled final : public Progress {
   public:
    void BeginStage(std::string_view) override {}
    void Report(double, std::string_view) override {}
    bool IsCancelled() const override { return true; }
  };
  test::TemporaryFolder folder;
  test::WritePaintedTileset(folder.path() / "map.mbtiles", {18, 256, 1001, 2002, 3, 3});
  Cancelled progress;
  const Result<void> written =
      WriteCog(folder.path() / "map.mbtiles", folder.path() / "map.tif", {}, progress);
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::kCancelled);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "map.tif"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "map.tif.tmp"));
}

}  // namespace
}  // namespace skyquilt::storage
