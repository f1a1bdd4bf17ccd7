#include "core/geo/web_mercator.h"

#include <gtest/gtest.h>
#include <proj.h>

#include <limits>
#include <utility>
#include <vector>

#include "core/geo/geodesic.h"
#include "core/geo/raster_frame.h"
#include "core/geo/tile_id.h"

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

TEST(WebMercator, AreasAreThoseOnTheEllipsoid) {
  constexpr double kSideM = 10'000.0;
  for (const double lat_deg : {-80.0, -33.0, 0.001, 46.8, 84.0}) {
    const Eigen::Vector2d middle = MercFromLatLon({lat_deg, 7.1});
    std::vector<LatLon> square;
    for (const auto& [x, y] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
      square.push_back(LatLonFromMerc(middle + kSideM * Eigen::Vector2d(x, y)));
    EXPECT_NEAR(GroundPerMercArea(lat_deg) * kSideM * kSideM / GeodesicAreaM2(square), 1.0, 1e-5) << lat_deg;
  }
}

TEST(LatLonBounds, AcrossTheAntimeridianGoOnBeyondItInTheEast) {
  const auto west_of = [](double west_deg, double east_deg) {
    const LatLonBounds turned = LatLonBounds{west_deg, -17.1, east_deg, -17.0}.OnEarth();
    EXPECT_NEAR(turned.east_deg - turned.west_deg, east_deg - west_deg, 1e-9);
    EXPECT_EQ(turned.south_deg, -17.1);
    EXPECT_EQ(turned.north_deg, -17.0);
    return turned.west_deg;
  };
  EXPECT_NEAR(west_of(-180.0006, -179.9994), 179.9994, 1e-9);
  EXPECT_NEAR(west_of(180.0006, 180.0009), -179.9994, 1e-9);
  EXPECT_EQ(west_of(179.9994, 180.0006), 179.9994);
  EXPECT_EQ(west_of(-180.0, 180.0), -180.0);
  EXPECT_EQ(west_of(-180.0000000000001, 180.0), -180.0);  // the whole Earth, as sums of tiles have it
  EXPECT_EQ(west_of(7.0, 7.1), 7.0);
}

TEST(LatLonBounds, GoAroundTheEarthForWhoKnowsNoneAcrossTheAntimeridian) {
  const LatLonBounds around{-180.0, -17.1, 180.0, -17.0};
  EXPECT_EQ((LatLonBounds{179.9, -17.1, 180.1, -17.0}.AroundWhereAcross()), around);
  EXPECT_EQ((LatLonBounds{-180.0, -17.1, 180.0000000000001, -17.0}.AroundWhereAcross()), around);
  const LatLonBounds beside{179.9, -17.1, 180.0, -17.0};
  EXPECT_EQ(beside.AroundWhereAcross(), beside);
}

TEST(LatLonBounds, OfBothSidesOfTheAntimeridianMeet) {
  LatLonBounds seen{179.9994, -17.1, 179.9999, -17.0};
  seen.Include(LatLonBounds{-179.9999, -17.2, -179.9994, -17.0}.Beside(seen));
  EXPECT_NEAR(seen.west_deg, 179.9994, 1e-9);
  EXPECT_NEAR(seen.east_deg, 180.0006, 1e-9);
  EXPECT_EQ(seen.south_deg, -17.2);
}

TEST(RasterFrame, PutsTheFirstPixelsCentreHalfAPixelInside) {
  const TileId tile = *TileId::Make(18, 64000, 92000);
  const RasterFrame frame = RasterFrame::OfTile(tile, 256);
  const Bounds2 bounds = tile.BoundsInMerc();
  const double pixel_m = PixelSizeInMercM(18, 256);
  EXPECT_NEAR(frame.MercFromPixel({0, 0}).x(), bounds.min.x() + 0.5 * pixel_m, 1e-6);
  EXPECT_NEAR(frame.MercFromPixel({0, 0}).y(), bounds.max.y() - 0.5 * pixel_m, 1e-6);
  EXPECT_NEAR(frame.MercFromPixel({17.25, 200.5}).x(), bounds.min.x() + 17.75 * pixel_m, 1e-6);
  EXPECT_NEAR(frame.MercFromPixel({17.25, 200.5}).y(), bounds.max.y() - 201 * pixel_m, 1e-6);
  EXPECT_NEAR(frame.BoundsInMerc().max.x(), bounds.max.x(), 1e-6);
}

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
