#include <gtest/gtest.h>

#include <cmath>

#include "core/simulate/world/render_photo.h"

namespace skyquilt::simulate {
namespace {

using std::chrono::sys_days;
using namespace std::chrono_literals;

double ElevationDeg(const Eigen::Vector3d& sun) { return geo::RadToDeg(std::asin(sun.z())); }

TEST(SunDirection, IsAUnitVector) {
  for (int hour = 0; hour < 24; ++hour) {
    const auto sun = SunDirection({-33.9, 151.2}, sys_days{2013y / 6 / 4} + std::chrono::hours(hour));
    EXPECT_NEAR(sun.norm(), 1.0, 1e-12);
  }
}

// At solar noon of a solstice the sun's elevation is 90 degrees less latitude, plus the tilt of the Earth's
// axis.
TEST(SunDirection, StandsSouthAtNoonOfTheSolstice) {
  // 2024-06-20: the equation of time is -1 min 44 s.
  const auto sun = SunDirection({46.8, 0.0}, sys_days{2024y / 6 / 20} + 12h + 1min + 44s);
  EXPECT_NEAR(ElevationDeg(sun), 90.0 - 46.8 + 23.44, 0.03);
  EXPECT_NEAR(geo::RadToDeg(std::atan2(sun.x(), -sun.y())), 0.0, 0.15);  // east of south
}

TEST(SunDirection, RisesInTheEastAndSetsInTheWestAtTheEquinox) {
  // 2024-03-20: the equation of time is -7 min 25 s; a quarter of a day on either side of noon.
  const auto noon = sys_days{2024y / 3 / 20} + 12h + 7min + 25s;
  const auto rising = SunDirection({0.0, 0.0}, noon - 6h), setting = SunDirection({0.0, 0.0}, noon + 6h);
  EXPECT_NEAR(ElevationDeg(rising), 0.0, 0.1);
  EXPECT_GT(rising.x(), 0.999);
  EXPECT_NEAR(ElevationDeg(setting), 0.0, 0.1);
  EXPECT_LT(setting.x(), -0.999);
  EXPECT_GT(ElevationDeg(SunDirection({0.0, 0.0}, noon)), 89.7);
}

TEST(SunDirection, GoesByTheLongitude) {
  const auto utc = sys_days{2016y / 6 / 23} + 18h;
  const auto west = SunDirection({46.84, -92.0}, utc), east = SunDirection({46.84, 88.0}, utc);
  EXPECT_GT(west.z(), 0.9);
  EXPECT_LT(east.z(), 0.0);
}

}  // namespace
}  // namespace skyquilt::simulate
