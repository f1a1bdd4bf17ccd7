#include "core/simulate/world/render_photo.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/simulate/sensors/trajectory.h"

namespace skyquilt::simulate {
namespace {

camera::Intrinsics BentLens() {
  camera::Intrinsics lens = camera::Intrinsics::Centered(640, 480, 500.0);
  lens.center_x_px += 7.3;
  lens.center_y_px -= 4.1;
  lens.focal_y_px = 503.0;
  lens.k1 = -0.12;
  lens.k2 = 0.03;
  lens.p1 = 0.0015;
  lens.p2 = -0.001;
  return lens;
}

// The middle of the white disc that lies about `near`, weighted by brightness.
Eigen::Vector2d DiscCenter(const image::DecodedImage& image, const Eigen::Vector2d& near, double radius_px) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weights = 0.0;
  for (int y = static_cast<int>(near.y() - radius_px); y <= near.y() + radius_px + 1.0; ++y) {
    for (int x = static_cast<int>(near.x() - radius_px); x <= near.x() + radius_px + 1.0; ++x) {
      if (x < 0 || y < 0 || x >= image.width_px || y >= image.height_px) continue;
      if ((Eigen::Vector2d(x, y) - near).norm() > radius_px) continue;
      const double weight = std::max(0.0, image.Row(y)[3 * x + 1] - 12.0);
      sum += weight * Eigen::Vector2d(x, y);
      weights += weight;
    }
  }
  return sum / weights;
}

TEST(RenderPhoto, ShowsSurveyMarksWhereTheProjectionPutsThem) {
  WorldOptions world_options;
  world_options.mark_spacing_m = 6.0;
  world_options.mark_radius_m = 0.25;
  for (const double relief_m : {0.0, 5.0}) {
    world_options.relief_m = relief_m;
    const World world(world_options);
    TrajectoryOptions flight;
    flight.photos = 6;
    flight.height_m = 30.0;
    flight.max_tilt_rad = geo::DegToRad(15.0);
    flight.yaw_rule = YawRule::kAnywhere;
    const camera::Intrinsics lens = BentLens();
    const auto poses = PlanLawnmower(flight, lens);
    ASSERT_TRUE(poses.ok());
    RenderPhotoOptions options;
    options.noise_counts = 0.0;
    int marks = 0;
    for (const TruePose& pose : *poses) {
      const auto image = RenderPhoto(world, lens, pose.cam_from_enu, options);
      for (int i = -15; i <= 15; ++i) {
        for (int j = -15; j <= 15; ++j) {
          const Eigen::Vector2d at(6.0 * i, 6.0 * j);
          const Eigen::Vector3d mark(at.x(), at.y(), world.TerrainHeightAt(at.x(), at.y()));
          const auto pixel = lens.Project(pose.cam_from_enu * mark);
          if (!pixel || pixel->x() < 15 || pixel->y() < 15 || pixel->x() > 625 || pixel->y() > 465) continue;
          const double px_per_m = 500.0 / (pose.cam_from_enu * mark).z();
          EXPECT_LT((DiscCenter(image, *pixel, 0.38 * px_per_m) - *pixel).norm(), 0.1) << i << " " << j;
          ++marks;
        }
      }
    }
    EXPECT_GT(marks, 60);
  }
}

TEST(RenderPhoto, GivesTheSameBytesOnAnyNumberOfThreads) {
  WorldOptions world_options;
  world_options.has_boxes = true;
  world_options.relief_m = 4.0;
  const World world(world_options);
  const camera::Intrinsics lens = BentLens();
  const auto pose = geo::Rigid3::FromRotationAndTargetOrigin(
      CamFromEnuOfGimbal({0.4, geo::DegToRad(-80.0), 0.0}), Eigen::Vector3d(20.0, -30.0, 70.0));
  RenderPhotoOptions options;
  options.motion_in_enu_m = {0.05, 0.02, 0.0};
  options.vignetting = 0.3;
  options.noise_counts = 2.0;
  options.threads = 1;
  const auto one = RenderPhoto(world, lens, pose, options);
  options.threads = 3;
  EXPECT_EQ(one.rgb, RenderPhoto(world, lens, pose, options).rgb);
}

World BareWorld() {
  WorldOptions bare;
  bare.texture = TextureLevel::kBare;
  return World(bare);
}

geo::Rigid3 LookingDown(double height_m) {
  return geo::Rigid3::FromRotationAndTargetOrigin(CamFromEnuOfGimbal({0.0, -0.5 * geo::kPi, 0.0}),
                                                  Eigen::Vector3d(0.0, 0.0, height_m));
}

double MeanGreen(const image::DecodedImage& image, int x0, int y0, int side) {
  double sum = 0.0;
  for (int y = y0; y < y0 + side; ++y) {
    for (int x = x0; x < x0 + side; ++x) sum += image.Row(y)[3 * x + 1];
  }
  return sum / (side * side);
}

TEST(RenderPhoto, VignettingAndExposureDarkenAsAsked) {
  const World world = BareWorld();
  const camera::Intrinsics lens = camera::Intrinsics::Centered(640, 480, 500.0);
  const geo::Rigid3 pose = LookingDown(50.0);
  RenderPhotoOptions options;
  const auto plain = RenderPhoto(world, lens, pose, options);
  options.vignetting = 0.4;
  options.exposure_gain = 0.8;
  const auto dark = RenderPhoto(world, lens, pose, options);
  EXPECT_NEAR(MeanGreen(dark, 300, 220, 40) / MeanGreen(plain, 300, 220, 40), 0.8, 0.01);
  EXPECT_NEAR(MeanGreen(dark, 0, 0, 6) / MeanGreen(plain, 0, 0, 6), 0.8 * 0.61, 0.01);
}

TEST(RenderPhoto, AHotSpotIsHalfAtItsWidth) {
  const World world = BareWorld();
  const camera::Intrinsics lens = camera::Intrinsics::Centered(641, 481, 500.0);
  const geo::Rigid3 pose = LookingDown(50.0);
  RenderPhotoOptions options;
  options.noise_counts = 0.0;
  options.exposure_gain = 0.7;
  const auto plain = RenderPhoto(world, lens, pose, options);
  options.hot_spot = 0.3;  // the sun in the zenith
  options.hot_spot_rad = std::atan(0.2);
  const auto lit = RenderPhoto(world, lens, pose, options);
  EXPECT_NEAR(MeanGreen(lit, 320, 240, 1) / MeanGreen(plain, 320, 240, 1), 1.3, 0.02);
  EXPECT_NEAR(MeanGreen(lit, 418, 238, 5) / MeanGreen(plain, 418, 238, 5), 1.15, 0.01);
}

TEST(RenderPhoto, MotionBlurSmearsAlongTheFlight) {
  const World world(WorldOptions{});
  const camera::Intrinsics lens = camera::Intrinsics::Centered(320, 240, 400.0);
  const geo::Rigid3 pose = LookingDown(20.0);
  RenderPhotoOptions options;
  options.noise_counts = 0.0;
  const auto contrast = [](const image::DecodedImage& image, int dx, int dy) {
    double sum = 0.0;
    for (int y = 0; y < 239; ++y) {
      for (int x = 0; x < 319; ++x) {
        const double step = image.Row(y + dy)[3 * (x + dx) + 1] - image.Row(y)[3 * x + 1];
        sum += step * step;
      }
    }
    return sum;
  };
  const auto sharp = RenderPhoto(world, lens, pose, options);
  options.motion_in_enu_m = {0.0, 0.3, 0.0};  // six pixels along the image's y
  const auto blurred = RenderPhoto(world, lens, pose, options);
  EXPECT_LT(contrast(blurred, 0, 1) / contrast(sharp, 0, 1),
            0.6 * contrast(blurred, 1, 0) / contrast(sharp, 1, 0));
}

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
