#include <gtest/gtest.h>

#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "storage/exports/cog_writer.h"
#include "storage/exports/warped/warp_tiles.h"
#include "storage/rasters/gdal_steps.h"
#include "tests/storage/painted_tileset.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

TEST(UtmEpsg, KnowsTheZonesAndTheirExceptions) {
  EXPECT_EQ(*UtmEpsg({46.8, 7.1}), 32632);
  EXPECT_EQ(*UtmEpsg({-33.9, 151.2}), 32756);
  EXPECT_EQ(*UtmEpsg({0.0, -180.0}), 32601);
  EXPECT_EQ(*UtmEpsg({0.0, 179.9}), 32660);
  EXPECT_EQ(*UtmEpsg({10.0, 180.5}), 32601);
  EXPECT_EQ(*UtmEpsg({60.0, 4.0}), 32632);   // Bergen
  EXPECT_EQ(*UtmEpsg({78.2, 15.6}), 32633);  // Longyearbyen
  EXPECT_FALSE(UtmEpsg({85.0, 0.0}).ok());
}

TEST(WriteUtmGeotiff, KeepsEveryPlaceAndTheMask) {
  RegisterGdalOnce();
  test::TemporaryFolder folder;
  const test::PaintedTileset tileset{19, 256, 272500, 184700, 4, 4};
  test::WritePaintedTileset(folder.path() / "map.mbtiles", tileset);
  SilentProgress progress;
  ASSERT_TRUE(WriteCog(folder.path() / "map.mbtiles", folder.path() / "map.tif", {}, progress));
  const Eigen::Vector2d middle_merc = geo::TileId::Make(19, 272502, 184702)->BoundsInMerc().min;
  const geo::LatLon middle =
      geo::LatLonFromMerc({middle_merc.x(), middle_merc.y() + geo::TileSizeInMercM(19)});
  const geo::Bounds2 whole{geo::TileId::Make(19, 272500, 184703)->BoundsInMerc().min,
                           geo::TileId::Make(19, 272503, 184700)->BoundsInMerc().max};
  const auto written = WriteUtmGeotiff(
      folder.path() / "map.mbtiles", folder.path() / "utm.tif",
      {geo::LatLonBoundsFromMerc(whole), 19, 19, {.pixel_x = 0.2, .pixel_y = 0.2}, 90, 1}, progress);
  ASSERT_TRUE(written.ok()) << written.error().message;
  const auto merc = test::OpenByGdal(folder / "map.tif"), utm = test::OpenByGdal(folder / "utm.tif");
  EXPECT_STREQ(utm->GetSpatialRef()->GetAuthorityCode(nullptr), std::to_string(*UtmEpsg(middle)).c_str());
  const auto from_merc = test::TransformOf(*merc), from_utm = test::TransformOf(*utm);
  EXPECT_NEAR(from_utm[1], 0.2, 1e-9);
  const std::unique_ptr<OGRCoordinateTransformation> utm_from_merc(
      OGRCreateCoordinateTransformation(merc->GetSpatialRef(), utm->GetSpatialRef()));
  ASSERT_NE(utm_from_merc, nullptr);
  int compared = 0;
  for (int y = 40; y < 1024; y += 61) {
    for (int x = 40; x < 1024; x += 61) {
      double east = from_merc[0] + (x + 0.5) * from_merc[1], north = from_merc[3] + (y + 0.5) * from_merc[5];
      ASSERT_TRUE(utm_from_merc->Transform(1, &east, &north));
      const int u = static_cast<int>(std::floor((east - from_utm[0]) / from_utm[1]));
      const int v = static_cast<int>(std::floor((north - from_utm[3]) / from_utm[5]));
      const double from_middle = std::hypot(x - 512.0, y - 512.0);
      if (from_middle > 480.0 && from_middle < 505.0) continue;  // the mask's edge itself
      ASSERT_EQ(test::PixelAt(*utm->GetRasterBand(1)->GetMaskBand(), u, v), from_middle < 490.0 ? 255 : 0);
      if (from_middle > 480.0) continue;
      ++compared;
      // The colours vary by at most 4 levels a pixel.
      for (int band = 1; band <= 3; ++band) {
        EXPECT_NEAR(test::PixelAt(*utm->GetRasterBand(band), u, v),
                    test::PixelAt(*merc->GetRasterBand(band), x, y), 12);
      }
    }
  }
  EXPECT_GT(compared, 100);
}

}  // namespace
}  // namespace skyquilt::storage
