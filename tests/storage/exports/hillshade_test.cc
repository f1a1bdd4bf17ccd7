#include "storage/exports/heights/hillshade.h"

#include <algorithm>
#include <cmath>

#include "tests/storage/exports/heights_raster.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

constexpr int kShadeSide = 600;
constexpr double kFarthestM = 25.0;  // beyond, nothing is known

// A cone of 45 degrees on a plain, in the middle.
double SteepConeAt(double east_m, double north_m) {
  constexpr double kHalfM = 0.5 * kShadeSide * kHeightsCellM;
  const double away_m = std::hypot(east_m - kHeightsWestM - kHalfM, north_m - kHeightsNorthM + kHalfM);
  return away_m > kFarthestM ? std::numeric_limits<double>::quiet_NaN()
                             : 500.0 + std::max(0.0, 10.0 - away_m);
}

TEST(Hillshade, IsBrightTowardsTheLightAndEmptyWhereNothingIsKnown) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  WriteHeights(folder.path() / "dsm.tif", kShadeSide, SteepConeAt);
  const Result<void> written = WriteHillshade(folder.path() / "dsm.tif", 1, progress);
  ASSERT_TRUE(written) << written.error().message;
  const auto shade = test::OpenByGdal(folder / "dsm_hillshade.tif");
  EXPECT_STREQ(shade->GetSpatialRef()->GetAuthorityCode(nullptr), "32632");
  EXPECT_EQ(shade->GetRasterXSize(), kShadeSide);
  EXPECT_EQ(shade->GetRasterBand(1)->GetRasterDataType(), GDT_Byte);
  EXPECT_EQ(shade->GetRasterBand(1)->GetNoDataValue(), 0.0);
  EXPECT_GE(shade->GetRasterBand(1)->GetOverviewCount(), 1);
  constexpr int kMiddle = kShadeSide / 2, kAway = 50;
  const auto at = [&](int column, int row) { return test::PixelAt(*shade->GetRasterBand(1), column, row); };
  const int north_west = at(kMiddle - kAway, kMiddle - kAway),
            south_east = at(kMiddle + kAway, kMiddle + kAway), plain = at(kMiddle + 3 * kAway, kMiddle);
  EXPECT_GT(north_west, plain);
  EXPECT_LT(south_east, plain - 60);
  EXPECT_GT(south_east, 0);
  EXPECT_EQ(at(2, 2), 0);
}

TEST(Hillshade, OfNoFileIsAnErrorAndLeavesNothing) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  EXPECT_EQ(test::ErrorOf(WriteHillshade(folder.path() / "dsm.tif", 1, progress)).code, ErrorCode::kIo);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace skyquilt::storage
