// bands.tif as GDAL reads it back.
#include "storage/rasters/bands_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>

#include "storage/rasters/gdal_steps.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

constexpr int kBlock = 1024;

bands::BandRaster TwoBlocks() {
  bands::BandRaster raster;
  raster.west_in_merc_m = 1000.0;
  raster.north_in_merc_m = 2000.0;
  raster.pixel_in_merc_m = 0.5;
  raster.width_px = 2 * kBlock;
  raster.height_px = kBlock;
  raster.block_px = kBlock;
  raster.bands = {{"green", 550.0, 40.0, "reflectance", "a method"}, {"nir", 0.0, 0.0, "radiance", ""}};
  return raster;
}

std::vector<std::vector<float>> Values(int from) {
  std::vector<std::vector<float>> values(2, std::vector<float>(std::size_t{kBlock} * kBlock, NAN));
  for (int y = from; y < kBlock; ++y) {
    for (int x = from; x < kBlock; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * kBlock + static_cast<std::size_t>(x);
      values[0][at] = static_cast<float>(x);
      if (x < 1000) values[1][at] = static_cast<float>(y);
    }
  }
  return values;
}

TEST(BandsWriterTest, WritesACloudOptimisedRasterOfWhatIsCovered) {
  const test::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "bands.tif";
  SilentProgress progress;
  {
    BandsWriter writer(path, 2, progress);
    ASSERT_TRUE(writer.Begin(TwoBlocks()).ok());
    ASSERT_TRUE(writer.Put(kBlock, 0, Values(100)).ok());
    ASSERT_TRUE(writer.Publish().ok());
  }
  RegisterGdalOnce();
  const auto read = test::OpenByGdal(path);
  EXPECT_EQ(read->GetRasterXSize(), kBlock - 100);
  EXPECT_EQ(read->GetRasterYSize(), kBlock - 100);
  EXPECT_STREQ(read->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  const auto transform = test::TransformOf(*read);
  EXPECT_DOUBLE_EQ(transform[0], 1000.0 + 0.5 * (kBlock + 100));
  EXPECT_DOUBLE_EQ(transform[3], 2000.0 - 0.5 * 100);
  ASSERT_EQ(read->GetRasterCount(), 2);
  GDALRasterBand& green = *read->GetRasterBand(1);
  EXPECT_STREQ(green.GetDescription(), "green");
  EXPECT_STREQ(green.GetMetadataItem("WAVELENGTH"), "550");
  EXPECT_STREQ(green.GetMetadataItem("WAVELENGTH_UNITS"), "nm");
  EXPECT_STREQ(green.GetMetadataItem("FWHM"), "40");
  EXPECT_STREQ(green.GetMetadataItem("CALIBRATION"), "reflectance");
  EXPECT_EQ(green.GetRasterDataType(), GDT_Float32);
  EXPECT_TRUE(std::isnan(green.GetNoDataValue()));
  EXPECT_GT(green.GetOverviewCount(), 0);
  EXPECT_STREQ(read->GetRasterBand(2)->GetDescription(), "nir");
  EXPECT_EQ(read->GetRasterBand(2)->GetMetadataItem("WAVELENGTH"), nullptr);
  EXPECT_FLOAT_EQ(test::PixelAt<float>(green, 7, 9), 107.0F);
  EXPECT_TRUE(std::isnan(test::PixelAt<float>(*read->GetRasterBand(2), 910, 9)));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 1);
}

TEST(BandsWriterTest, WithoutAnyValueThereIsNoFile) {
  const test::TemporaryFolder scratch;
  SilentProgress progress;
  BandsWriter writer(scratch.path() / "bands.tif", 1, progress);
  ASSERT_TRUE(writer.Begin(TwoBlocks()).ok());
  ASSERT_TRUE(writer.Put(0, 0, Values(kBlock)).ok());
  ASSERT_TRUE(writer.Publish().ok());
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "bands.tif"));
}

TEST(BandsWriterTest, AFolderThatIsNotThereIsSaid) {
  SilentProgress progress;
  BandsWriter writer("/nowhere/at/all/bands.tif", 1, progress);
  EXPECT_EQ(test::ErrorOf(writer.Begin(TwoBlocks())).code, ErrorCode::kIo);
}

}  // namespace
}  // namespace skyquilt::storage
