#include "core/geo/tile_id.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/geo/web_mercator.h"

namespace skyquilt::geo {
namespace {

TEST(TileId, RefusesWhatIsOutsideTheSquare) {
  EXPECT_FALSE(TileId::Make(-1, 0, 0).ok());
  EXPECT_FALSE(TileId::Make(31, 0, 0).ok());
  EXPECT_FALSE(TileId::Make(3, 8, 0).ok());
  EXPECT_FALSE(TileId::Make(3, 0, -1).ok());
  EXPECT_TRUE(TileId::Make(3, 7, 7).ok());
  EXPECT_TRUE(TileId::Make(30, (1LL << 30) - 1, 0).ok());
}

TEST(TileId, CountsRowsFromTheNorthAndTmsFromTheSouth) {
  const TileId north_west = TileId::AtMerc(2, MercFromLatLon({80.0, -179.0}));
  EXPECT_EQ(north_west.x(), 0u);
  EXPECT_EQ(north_west.y(), 0u);
  EXPECT_EQ(north_west.TmsRow(), 3u);
}

TEST(TileId, HoldsItsPointAndItsChildren) {
  const Eigen::Vector2d point = MercFromLatLon({46.8426, -91.994});
  TileId tile = TileId::AtMerc(23, point);
  while (tile.z() > 0) {
    EXPECT_TRUE(tile.BoundsInMerc().Contains(point));
    const TileId parent = tile.Parent();
    const auto children = parent.Children();
    EXPECT_NE(std::find(children.begin(), children.end(), tile), children.end());
    tile = parent;
  }
  EXPECT_NEAR(tile.BoundsInMerc().max.x(), 20037508.342789244, 1e-6);
}

TEST(ZoomForGsd, StaysOnTheScaleOfZooms) {
  EXPECT_EQ(ZoomForGsd(1e300, 46.8, 256), 0);
  EXPECT_EQ(ZoomForGsd(std::numeric_limits<double>::infinity(), 46.8, 256), 0);
  EXPECT_EQ(ZoomForGsd(1e-300, 46.8, 256), kMaxZoom);
}

TEST(ZoomForGsd, IsNeverCoarserThanAskedAndNeverTwiceTooFine) {
  for (const double lat_deg : {-68.0, 0.0, 46.8}) {
    for (double gsd_m = 0.004; gsd_m < 3.0; gsd_m *= 1.37) {
      const int zoom = ZoomForGsd(gsd_m, lat_deg, 256);
      const double pixel_m = PixelSizeInMercM(zoom, 256) * GroundMetresPerMercMetre(lat_deg);
      EXPECT_LE(pixel_m, gsd_m * 1.0000001);
      EXPECT_GT(pixel_m, 0.5 * gsd_m);
    }
  }
}

}  // namespace
}  // namespace skyquilt::geo
