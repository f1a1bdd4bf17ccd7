#include "core/geo/local_frame.h"

#include <gtest/gtest.h>
#include <proj.h>

#include <cmath>
#include <random>
#include <string>

#include "core/geo/geoid.h"

namespace skyquilt::geo {
namespace {

// PROJ as the oracle: geodetic to ECEF to topocentric.
class ProjTopocentric {
 public:
  explicit ProjTopocentric(const Wgs84& origin) {
    const std::string pipeline =
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 +step "
        "+proj=topocentric +ellps=WGS84 +lon_0=" +
        std::to_string(origin.lon_deg) + " +lat_0=" + std::to_string(origin.lat_deg) +
        " +h_0=" + std::to_string(origin.height_ellipsoid_m);
    transform_ = proj_create(PJ_DEFAULT_CTX, pipeline.c_str());
  }
  ~ProjTopocentric() { proj_destroy(transform_); }
  Eigen::Vector3d operator()(const Wgs84& point) const {
    const PJ_COORD out = proj_trans(transform_, PJ_FWD,
                                    proj_coord(point.lon_deg, point.lat_deg, point.height_ellipsoid_m, 0.0));
    return {out.xyz.x, out.xyz.y, out.xyz.z};
  }

 private:
  PJ* transform_ = nullptr;
};

TEST(LocalFrame, AgreesWithProjToAMillimetreOverFiveKilometres) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> offset_deg(-0.022, 0.022);
  std::uniform_real_distribution<double> height_m(-50.0, 500.0);
  for (const double lat_deg : {-70.0, -33.0, 0.0, 46.0, 70.0}) {
    for (const double lon_deg : {-179.99, -92.0, 0.0, 12.5}) {
      const Wgs84 origin{lat_deg, lon_deg, 200.0};
      const LocalFrame frame(origin);
      const ProjTopocentric oracle(origin);
      for (int i = 0; i < 50; ++i) {
        const Wgs84 point{lat_deg + offset_deg(random), lon_deg + offset_deg(random), height_m(random)};
        const Eigen::Vector3d ours = frame.EnuFromWgs84(point);
        EXPECT_LT((ours - oracle(point)).norm(), 1e-3) << lat_deg << " " << lon_deg;
        const Wgs84 back = frame.Wgs84FromEnu(ours);
        EXPECT_NEAR(back.lat_deg, point.lat_deg, 1e-11);
        EXPECT_NEAR(std::remainder(back.lon_deg - point.lon_deg, 360.0), 0.0, 1e-11);
        EXPECT_NEAR(back.height_ellipsoid_m, point.height_ellipsoid_m, 1e-6);
      }
    }
  }
}

TEST(LocalFrame, FindsThePointOfAPlaneAtAGeographicPosition) {
  const LocalFrame frame({46.8, -92.0, 180.0});
  for (const double z_m : {-20.0, 0.0, 35.0}) {
    const Eigen::Vector3d point = frame.EnuAtHeight({46.82, -91.97}, z_m);
    EXPECT_NEAR(point.z(), z_m, 1e-8);
    const Wgs84 wgs84 = frame.Wgs84FromEnu(point);
    EXPECT_NEAR(wgs84.lat_deg, 46.82, 1e-12);
    EXPECT_NEAR(wgs84.lon_deg, -91.97, 1e-12);
  }
}

TEST(LocalFrame, HasEastNorthUpWhereTheyBelong) {
  const LocalFrame frame({-60.0, 30.0, 0.0});
  EXPECT_GT(frame.EnuFromWgs84({-60.0, 30.001, 0.0}).x(), 50.0);
  EXPECT_GT(frame.EnuFromWgs84({-59.999, 30.0, 0.0}).y(), 100.0);
  EXPECT_NEAR(frame.EnuFromWgs84({-60.0, 30.0, 25.0}).z(), 25.0, 1e-8);
}

TEST(Ecef, RoundTripsFromTheDeepSeaToSpace) {
  for (double lat_deg = -90.0; lat_deg <= 90.0; lat_deg += 7.5) {
    for (const double height_m : {-10000.0, 0.0, 8848.0, 400000.0}) {
      const Wgs84 back = Wgs84FromEcef(EcefFromWgs84({lat_deg, 77.0, height_m}));
      EXPECT_NEAR(back.lat_deg, lat_deg, 1e-10);
      EXPECT_NEAR(back.height_ellipsoid_m, height_m, 1e-4);
    }
  }
}

TEST(LatLon, RefusesWhatIsNotOnEarth) {
  EXPECT_FALSE(LatLon::Make(91.0, 0.0).ok());
  EXPECT_FALSE(LatLon::Make(0.0, -180.5).ok());
  EXPECT_FALSE(LatLon::Make(std::nan(""), 0.0).ok());
  EXPECT_TRUE(LatLon::Make(-90.0, 180.0).ok());
}

TEST(Geoid, IsWhereEgm96SaysItIs) {
  const auto paris = GeoidHeightM({48.85, 2.35});
  if (!paris) GTEST_SKIP() << "PROJ has no EGM96 grid here (Debian: proj-data)";
  EXPECT_NEAR(*paris, 44.6, 1.0);
  EXPECT_NEAR(*GeoidHeightM({4.0, 78.0}), -103.0, 4.0);  // the Indian Ocean low
}

Rigid3 RandomRigid(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond rotation(normal(random), normal(random), normal(random), normal(random));
  return {rotation.normalized(), 100.0 * Eigen::Vector3d(normal(random), normal(random), normal(random))};
}

TEST(Rigid3, ComposesAndInvertsLikeTheMotionsItStandsFor) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const Rigid3 a_from_b = RandomRigid(random);
    const Rigid3 b_from_c = RandomRigid(random);
    const Eigen::Vector3d point = RandomRigid(random).translation;
    EXPECT_LT(((a_from_b * b_from_c) * point - a_from_b * (b_from_c * point)).norm(), 1e-9);
    EXPECT_LT((a_from_b.Inverse() * (a_from_b * point) - point).norm(), 1e-9);
    EXPECT_LT((a_from_b * a_from_b.TargetOriginInSource()).norm(), 1e-9);
    const Rigid3 again =
        Rigid3::FromRotationAndTargetOrigin(a_from_b.rotation, a_from_b.TargetOriginInSource());
    EXPECT_LT((again * point - a_from_b * point).norm(), 1e-9);
  }
}

TEST(RotationVector, RoundTripsFromTinyToHalfATurn) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (const double angle : {0.0, 1e-12, 1e-7, 1e-3, 1.0, 3.1}) {
    const Eigen::Vector3d omega =
        angle * Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    EXPECT_LT((VectorFromRotation(RotationFromVector(omega)) - omega).norm(), 1e-12 + 1e-9 * angle) << angle;
  }
}

}  // namespace
}  // namespace skyquilt::geo
