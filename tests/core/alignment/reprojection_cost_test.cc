#include "core/alignment/bundle/reprojection_cost.h"

#include <Eigen/Geometry>

#include "tests/core/alignment/cost_derivatives.h"

namespace skyquilt::alignment {
namespace {

constexpr double kSigmaPx = 0.7;

struct Case {
  geo::Rigid3 start = geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(Eigen::AngleAxisd(3.0, Eigen::Vector3d(1.0, 0.2, 0.1).normalized())),
      {4.0, -3.0, 60.0});
  camera::Intrinsics lens;
  Eigen::Vector2d pixel{1200.0, 900.0};
  CostValues values{{0.02, -0.05, 0.3, 0.5, -0.4, 0.8},
                    {10.0, 6.0, 2.0},
                    {0.01, 3.0, -2.0, -0.1, 0.05, 0.001, -0.002}};  // pose, point, lens

  Case() {
    lens.width_px = 2000, lens.height_px = 1500;
    lens.focal_x_px = 1400.0, lens.focal_y_px = 1390.0, lens.center_x_px = 1010.0, lens.center_y_px = 745.0;
    lens.k3 = 0.02;
  }
  std::unique_ptr<ceres::CostFunction> Cost() const {
    return std::unique_ptr<ceres::CostFunction>(
        MakeReprojectionCost(StartOf(start, {}, lens), pixel, kSigmaPx));
  }
};

TEST(ReprojectionCost, IsHowFarThePixelLiesFromWhereTheCameraSeesThePoint) {
  const Case at;
  camera::Intrinsics lens = at.lens;
  lens.focal_x_px *= std::exp(at.values[2][0]), lens.focal_y_px *= std::exp(at.values[2][0]);
  lens.center_x_px += at.values[2][1], lens.center_y_px += at.values[2][2];
  lens.k1 = at.values[2][3], lens.k2 = at.values[2][4], lens.p1 = at.values[2][5], lens.p2 = at.values[2][6];
  const Eigen::Vector3d turn(at.values[0].data());
  const Eigen::Quaterniond rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * at.start.rotation;
  const Eigen::Vector3d in_cam =
      rotation * (Eigen::Vector3d(at.values[1].data()) - at.start.TargetOriginInSource() -
                  Eigen::Vector3d(at.values[0].data() + 3));
  const Eigen::Vector2d bent = lens.Distort(in_cam.head<2>() / in_cam.z());
  const Eigen::Vector2d seen(lens.focal_x_px * bent.x() + lens.center_x_px,
                             lens.focal_y_px * bent.y() + lens.center_y_px);
  EXPECT_LT((ResidualAt(*at.Cost(), at.values) - (seen - at.pixel) / kSigmaPx).norm(), 1e-9);
}

TEST(ReprojectionCost, ChangesAsItsDerivativesSay) {
  for (const double turned : {0.0, 1e-5, 1.0}) {  // the start itself, the series, the full formula
    Case at;
    for (int k = 0; k < 3; ++k) at.values[0][k] *= turned;
    SCOPED_TRACE(turned);
    ExpectOwnDerivatives(*at.Cost(), at.values);
  }
}

TEST(ReprojectionCost, RefusesAPointBehindTheCamera) {
  Case at;
  at.values[1] = {4.0, -3.0, 100.0};
  Eigen::Vector2d residual;
  EXPECT_FALSE(at.Cost()->Evaluate(BlocksOf(at.values).data(), residual.data(), nullptr));
}

}  // namespace
}  // namespace skyquilt::alignment
