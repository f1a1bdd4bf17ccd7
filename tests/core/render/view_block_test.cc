// Where a photo sees the nodes of a block over ground with steps, against each node projected for itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/camera/rolling_shutter.h"
#include "core/geo/web_mercator.h"
#include "core/render/blocks/block_geometry.h"

namespace skyquilt::render {
namespace {

constexpr int kBlockZoom = 20, kBlockPx = 256;  // 15 cm a pixel there

class ViewBlockTest : public testing::Test {
 protected:
  ViewBlockTest() {
    std::vector<float> heights(400 * 400, 0.0f);
    for (std::size_t i = 0; i < heights.size(); ++i) {
      if (i % 400 / 40 % 2 == 1) heights[i] = 6.0f;  // every second strip of 10 m is a roof
    }
    ground_ = ground::GroundSurface::WithSteps({-50.0, -50.0}, 0.25, 400, 400, std::move(heights), 0.0);
    photo_.intrinsics.width_px = 1200;
    photo_.intrinsics.height_px = 900;
    photo_.intrinsics.focal_x_px = photo_.intrinsics.focal_y_px = 1000.0;
    photo_.intrinsics.center_x_px = 599.5;
    photo_.intrinsics.center_y_px = 449.5;
    photo_.intrinsics.k1 = -0.05;
    const Eigen::Quaterniond down(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()) *
                                  Eigen::AngleAxisd(0.1, Eigen::Vector3d(1.0, 0.5, 0.3).normalized()));
    photo_.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(down, {3.0, -4.0, 60.0});
  }

  // The furthest that a node of the photo's picture lies off, in pixels; all of them are seen.
  double Furthest() const {
    const geo::TileId tile = geo::TileId::AtMerc(kBlockZoom, geo::MercFromLatLon({46.8, 7.1}));
    const BlockGeometry block = MakeBlockGeometry(tile, kBlockPx, frame_, ground_);
    EXPECT_EQ(block.node_step_px, kNodeStepOverStepsPx);
    const PhotoView view = ViewBlock(photo_, block);
    double furthest = 0.0;
    int inside = 0;
    for (std::size_t i = 0; i < block.ground_in_enu.size(); ++i) {
      const auto pixel = camera::ProjectRolling(photo_.intrinsics, photo_.cam_from_enu, photo_.readout_motion,
                                                block.ground_in_enu[i]);
      if (!pixel || (pixel->array() < 0.0).any() || pixel->x() > 1199.0 || pixel->y() > 899.0) continue;
      ++inside;
      const double off_px = (view.pixel_in_image[i].cast<double>() - *pixel).norm();
      EXPECT_FALSE(std::isnan(off_px));
      furthest = std::max(furthest, off_px);
    }
    EXPECT_GT(inside, 5000);
    return furthest;
  }

  const geo::LocalFrame frame_{geo::Wgs84{46.8, 7.1, 500.0}};
  ground::GroundSurface ground_ = ground::GroundSurface::Plane(0.0);
  alignment::AlignedPhoto photo_;
};

TEST_F(ViewBlockTest, IsExactWhereTheCameraStandsStill) { EXPECT_LT(Furthest(), 1e-3); }

TEST_F(ViewBlockTest, FollowsTheRowsOfACameraThatFliesOn) {
  photo_.readout_motion.shift_in_enu_m = {0.3, 0.2, 0.0};  // 10 m/s and 36 ms
  EXPECT_LT(Furthest(), 0.05);
}

TEST_F(ViewBlockTest, FollowsTheRowsOfACameraThatTurns) {
  photo_.readout_motion.shift_in_enu_m = {0.3, 0.2, 0.0};
  for (int i = 0; i < 8; ++i)
    photo_.readout_motion.turns_rad.emplace_back(0.002 * (i - 3.5), -0.003 * (i - 3.5), 0.001 * std::sin(i));
  EXPECT_LT(Furthest(), 0.05);
}

}  // namespace
}  // namespace skyquilt::render
