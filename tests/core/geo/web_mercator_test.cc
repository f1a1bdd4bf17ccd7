#include "core/geo/web_mercator.h"

#include <gtest/gtest.h>
#include <proj.h>

#include "core/geo/raster_frame.h"

namespace skyquilt::geo {
namespace {

TEST(WebMercator, AgreesWithProjAndRoundTrips) {
  PJ* oracle = proj_create_crs_to_crs(PJ_DEFAULT_CTX, "EPSG:4326", "EPSG:3857", nullptr);
  ASSERT_NE(oracle, nullptr);
  for (double lat_deg = -85.0; lat_deg <= 85.0; lat_deg += 8.5) {
    for (const double lon_deg : {-180.0, -91.99, 0.0, 133.7}) {
      const Eigen::Vector2d ours = MercFromLatLon({lat_deg, lon_deg});
      const PJ_COORD theirs = proj_trans(oracle, PJ_FWD, proj_coord(lat_deg, lon_deg, 0.0, 0.0));
      EXPECT_NEAR(ours.x(), theirs.xy.x, 1e-6);
      EXPECT_NEAR(ours.y(), theirs.xy.y, 1e-6);
      const LatLon back = LatLonFromMerc(ours);
      EXPECT_NEAR(back.lat_deg, lat_deg, 1e-12);
      EXPECT_NEAR(back.lon_deg, lon_deg, 1e-12);
    }
  }
  proj_destroy(oracle);
}

TEST(RasterFrame, PutsTheFirstPixelsCentreHalfAPixelInside) {
  const TileId tile = *TileId::Make(18, 64000, 92000);
  const RasterFrame frame = RasterFrame::OfTile(tile, 256);
  const Bounds2 bounds = tile.BoundsInMerc();
  const double pixel_m = PixelSizeInMercM(18, 256);
  EXPECT_NEAR(frame.MercFromPixel({0, 0}).x(), bounds.min.x() + 0.5 * pixel_m, 1e-6);
  EXPECT_NEAR(frame.MercFromPixel({0, 0}).y(), bounds.max.y() - 0.5 * pixel_m, 1e-6);
  EXPECT_NEAR(frame.BoundsInMerc().max.x(), bounds.max.x(), 1e-6);
}

}  // namespace
}  // namespace skyquilt::geo
