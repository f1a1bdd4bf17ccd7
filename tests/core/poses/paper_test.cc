// The source paper's equations as it prints them, held against what is right: how wrong they are, in numbers.
// K. Iz and M. Unel, Aerial Image Stitching Using IMU Data from a UAV. The table in core/poses/README.md
// leads here.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/geo/lat_lon.h"
#include "core/poses/conventions/attitude_convention.h"
#include "tests/bench/poses/strapdown.h"
#include "tests/support/ground_homography.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const camera::Intrinsics& Lens() {
  static const camera::Intrinsics lens = camera::Intrinsics::Centered(5472, 3648, 3650.0);
  return lens;
}

Matrix3d GroundMap(double yaw_deg, double pitch_deg, double height_m) {
  flight::RecordedAttitude attitude;
  attitude.yaw_rad = geo::DegToRad(yaw_deg);
  attitude.pitch_rad = geo::DegToRad(pitch_deg);
  const auto pose = geo::Rigid3::FromRotationAndTargetOrigin(CamFromEnu(attitude), {0.0, 0.0, height_m});
  return test::GroundHomography(Lens(), pose, 0.0);
}

Vector2d Apply(const Matrix3d& map, const Vector2d& pixel) {
  const Vector3d image = map * pixel.homogeneous();
  return image.head<2>() / image.z();
}

template <typename Map>
double RmsAgainst(const Matrix3d& truth, Map map) {
  double sum = 0.0;
  int count = 0;
  for (int y = 0; y < Lens().height_px; y += 200) {
    for (int x = 0; x < Lens().width_px; x += 200, ++count) {
      const Vector2d pixel(x, y);
      sum += (Apply(truth, pixel) - map(pixel)).squaredNorm();
    }
  }
  return std::sqrt(sum / count);
}

TEST(PaperLiteralForm, TheWarpOfEquation7GoesTheOtherWay) {
  // T = M_{k+1} Q M_k^-1 carries image k to k+1; applied to image k+1 it doubles the motion that it should
  // undo.
  const Matrix3d first = GroundMap(0.0, -90.0, 60.0);
  Matrix3d shift = Matrix3d::Identity();
  shift(1, 2) = -10.0;  // the second photo was taken 10 m further north
  const Matrix3d second = first * shift;
  const Matrix3d second_from_first = second * first.inverse();
  const Vector2d middle(Lens().center_x_px, Lens().center_y_px);
  const Vector2d right = Apply(second_from_first.inverse(), middle);
  const Vector2d printed = Apply(second_from_first, middle);
  EXPECT_NEAR((right - printed).norm(), 2.0 * 10.0 * 3650.0 / 60.0, 1.0);
}

TEST(PaperLiteralForm, TheScaleOfEquation8IsTheWrongWayUp) {
  const Matrix3d high_from_low = GroundMap(0.0, -90.0, 25.0) * GroundMap(0.0, -90.0, 20.0).inverse();
  EXPECT_NEAR(high_from_low(0, 0) / high_from_low(2, 2), 0.8, 1e-12);  // printed: 25 / 20 = 1.25
}

TEST(PaperLiteralForm, ScalingTheWholeMatrixAsInEquation9ChangesNothing) {
  const Matrix3d map = GroundMap(20.0, -85.0, 60.0);
  const Vector2d pixel(1000.0, 700.0);
  EXPECT_LT((Apply(1.25 * map, pixel) - Apply(map, pixel)).norm(), 1e-9);
  EXPECT_GT((Apply(Vector3d(0.8, 0.8, 1.0).asDiagonal() * map, pixel) - Apply(map, pixel)).norm(), 100.0);
}

TEST(PaperLiteralForm, AYawDifferenceThatIsNotWrappedTurnsTheLongWay) {
  const double before_deg = 179.0, after_deg = -179.0;
  EXPECT_DOUBLE_EQ(after_deg - before_deg, -358.0);  // equation (11)
  EXPECT_NEAR(geo::RadToDeg(geo::WrapRad(geo::DegToRad(after_deg - before_deg))), 2.0, 1e-9);
}

TEST(PaperLiteralForm, RotationOfPixelsAsInEquation13TurnsAboutTheCorner) {
  const Matrix3d truth = GroundMap(0.0, -90.0, 60.0) * GroundMap(10.0, -90.0, 60.0).inverse();
  const double yaw = geo::DegToRad(10.0);
  const Matrix3d about_corner = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix();
  const Matrix3d conjugated = Lens().K() * about_corner * Lens().K().inverse();
  const double literal = RmsAgainst(truth, [&](const Vector2d& p) { return Apply(about_corner, p); });
  const double corrected = RmsAgainst(truth, [&](const Vector2d& p) { return Apply(conjugated, p); });
  EXPECT_LT(corrected, 1e-6);
  EXPECT_NEAR(literal, 573.0, 15.0);  // pixels: the image's middle goes round the corner
}

TEST(PaperLiteralForm, ShearForPitchAsInEquations15And16IsWorseThanDoingNothing) {
  const auto errors = [](double pitch_deg) {
    const Matrix3d truth = GroundMap(0.0, -90.0, 60.0) * GroundMap(0.0, -90.0 + pitch_deg, 60.0).inverse();
    const double mu = geo::DegToRad(pitch_deg);
    const Matrix3d tilt = Eigen::AngleAxisd(-mu, Vector3d::UnitX()).toRotationMatrix();
    const Matrix3d homography = Lens().K() * tilt * Lens().K().inverse();
    const Matrix3d other_way = Lens().K() * tilt.transpose() * Lens().K().inverse();
    return std::array<double, 3>{
        RmsAgainst(truth, [](const Vector2d& p) { return p; }),
        RmsAgainst(truth,
                   [&](const Vector2d& p) {
                     return Vector2d(p.x(), p.y() + std::tan(mu) * (p.x() - Lens().center_x_px));
                   }),
        std::min(RmsAgainst(truth, [&](const Vector2d& p) { return Apply(homography, p); }),
                 RmsAgainst(truth, [&](const Vector2d& p) { return Apply(other_way, p); }))};
  };
  const auto [nothing_5, shear_5, right_5] = errors(5.0);
  EXPECT_NEAR(nothing_5, 354.0, 12.0);
  EXPECT_NEAR(shear_5, 382.0, 12.0);
  EXPECT_LT(right_5, 1e-6);
  const auto [nothing_10, shear_10, right_10] = errors(10.0);
  EXPECT_NEAR(nothing_10, 716.0, 20.0);
  EXPECT_NEAR(shear_10, 773.0, 20.0);
  EXPECT_LT(right_10, 1e-6);
}

TEST(PaperLiteralForm, DoubleIntegrationWithoutGravityAndRotationFallsFromTheSky) {
  // Equations (1)-(3) as printed sum what the accelerometer shows. A hovering one shows the thrust that
  // carries it.
  std::vector<flight::ImuSample> hover;
  for (int k = 0; k <= 1000; ++k)
    hover.push_back({0.01 * k, Vector3d::Zero(), {0.0, 0.0, -kStandardGravityMps2}});
  StrapdownState start;
  start.enu_from_body = EnuFromNed();  // nose north, level
  EXPECT_LT(test::ValueOf(IntegrateStrapdown(hover, start)).back().position_in_enu_m.norm(), 1e-9);
  double velocity = 0.0, position = 0.0;
  for (std::size_t k = 1; k < hover.size(); ++k) {
    const double next =
        velocity + 0.01 * 0.5 * (hover[k - 1].specific_force_mps2.z() + hover[k].specific_force_mps2.z());
    position += 0.01 * 0.5 * (velocity + next);
    velocity = next;
  }
  EXPECT_NEAR(position, -490.3, 0.5);  // metres after ten seconds of standing still
}

TEST(PaperLiteralForm, NeitherTrapezoidNorSimpsonMitigatesDrift) {
  // A bias of 5 mg for 60 s: both rules give the same 88 m.
  constexpr double kBias = 0.005 * kStandardGravityMps2;
  std::vector<flight::ImuSample> still;
  for (int k = 0; k <= 6000; ++k) {
    still.push_back({0.01 * k, Vector3d::Zero(), {kBias, 0.0, -kStandardGravityMps2}});
  }
  StrapdownState start;
  start.enu_from_body = EnuFromNed();
  StrapdownOptions options;
  for (const IntegrationRule rule : {IntegrationRule::kTrapezoid, IntegrationRule::kSimpson}) {
    options.rule = rule;
    const auto drifted = test::ValueOf(IntegrateStrapdown(still, start, options));
    EXPECT_NEAR(drifted.back().position_in_enu_m.norm(), 0.5 * kBias * 3600.0, 0.1);
  }
}

}  // namespace
}  // namespace skyquilt::poses
