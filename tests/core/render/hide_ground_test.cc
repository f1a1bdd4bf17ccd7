// Ground behind a wall is shown by the photos that see it, and by whoever looks there where none does.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/render/blocks/weigh_block.h"

namespace skyquilt::render {
namespace {

constexpr int kHouseCells = 200;
constexpr double kHouseCellM = 0.1;

// A flat roof 4 m high from 8 to 12 m east.
ground::GroundSurface LongHouse() {
  std::vector<float> heights(static_cast<std::size_t>(kHouseCells) * kHouseCells, 0.0f);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const std::size_t column = i % kHouseCells;
    if (column >= 80 && column < 120) heights[i] = 4.0f;
  }
  return ground::GroundSurface::WithSteps({0.0, 0.0}, kHouseCellM, kHouseCells, kHouseCells,
                                          std::move(heights), 0.0);
}

alignment::AlignedPhoto Above(double east, double north) {
  alignment::AlignedPhoto photo;
  photo.intrinsics.width_px = photo.intrinsics.height_px = 100;
  photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX())), {east, north, 40.0});
  return photo;
}

PhotoView SeeingAll(std::size_t nodes) {
  PhotoView view;
  view.pixel_in_image.assign(nodes, {50.0f, 50.0f});
  view.nadir_distance_m.assign(nodes, 1.0f);
  view.sees_block = true;
  return view;
}

class HideGroundTest : public testing::Test {
 protected:
  HideGroundTest() {
    block_.ground_in_enu = {
        {12.5, 10.0, 0.0}, {7.5, 10.0, 0.0}, {10.0, 10.0, 4.0}};  // east, west, on the roof
    flight_.photos = {Above(2.0, 10.0), Above(18.0, 10.0), Above(1.0, 10.0)};
  }
  std::vector<PhotoView> ViewsOf(const std::vector<std::uint32_t>& photos,
                                 std::size_t beyond_edge = 99) const {
    std::vector<PhotoView> views(photos.size(), SeeingAll(block_.ground_in_enu.size()));
    if (beyond_edge < views.size()) views[beyond_edge].pixel_in_image[0] = {-20.0f, 50.0f};
    HideGround(flight_, LongHouse(), photos, block_, std::vector<std::uint8_t>(3, 1), views);
    return views;
  }
  alignment::AlignedFlight flight_;
  BlockGeometry block_;
};

TEST_F(HideGroundTest, EachSideIsOccludedFromTheOther) {
  const auto views = ViewsOf({0, 1});
  EXPECT_EQ(views[0].is_hidden, (std::vector<bool>{true, false, false}));
  EXPECT_EQ(views[1].is_hidden, (std::vector<bool>{false, true, false}));
}

TEST_F(HideGroundTest, WhatNoPhotoSeesIsOccludedFromNone) {
  for (const PhotoView& view : ViewsOf({0, 2})) EXPECT_TRUE(view.is_hidden.empty());
  // Nor where the one that would see it ends before.
  EXPECT_TRUE(ViewsOf({0, 1}, 1)[0].is_hidden.empty());
}

TEST_F(HideGroundTest, WhatIsNotAskedIsNotLookedAt) {
  std::vector<PhotoView> views(2, SeeingAll(block_.ground_in_enu.size()));
  HideGround(flight_, LongHouse(), {0, 1}, block_, {0, 1, 1}, views);
  EXPECT_TRUE(views[0].is_hidden.empty());
  EXPECT_TRUE(views[1].is_hidden[1]);
}

TEST_F(HideGroundTest, SmoothGroundHidesNothing) {
  std::vector<PhotoView> views(1, SeeingAll(block_.ground_in_enu.size()));
  HideGround(flight_, ground::GroundSurface::Plane(0.0), {0}, block_, {}, views);
  EXPECT_TRUE(views[0].is_hidden.empty());
}

}  // namespace
}  // namespace skyquilt::render
