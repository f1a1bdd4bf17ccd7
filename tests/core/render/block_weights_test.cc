// Which photo shows what of a block: where it sees the block's nodes, what hides them from it, how much it
// counts.
#include "core/render/blocks/block_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/camera/rolling_shutter.h"
#include "core/geo/web_mercator.h"
#include "core/ground/ground_surface.h"
#include "core/render/blocks/weigh_block.h"
#include "tests/support/simulated_map.h"

namespace skyquilt::render {
namespace {

// Nodes over ground with steps, against each node projected for itself.
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

// Ground behind a wall is shown by the photos that see it, and by whoever looks there where none does.
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

class WeighPhotosTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    map_ = new test::SimulatedMap(test::MakeSimulatedMap(test::SmallPhotos(12)));
    seams_ = new SeamMap(map_->Seams({}));
  }
  static void TearDownTestSuite() {
    delete seams_;
    delete map_;
  }
  static int SidePx() { return map_->plan.tile_size_px << map_->plan.block_levels; }
  static WeighedBlock Weigh(const RenderBlock& block) {
    return WeighBlock(map_->flight, map_->ground, *seams_, map_->plan, block,
                      MakeBlockGeometry(block.tile, SidePx(), map_->flight.frame, map_->ground));
  }
  // Of each pixel of the block: the sum of all weights, and how many photos have some.
  struct Sums {
    std::vector<float> weight;
    std::vector<int> photos;
  };
  static Sums SumsOf(const BlockShares& shares) {
    const auto side = static_cast<std::size_t>(SidePx());
    Sums sums{std::vector<float>(side * side, 0.0F), std::vector<int>(side * side, 0)};
    for (const PhotoShare& share : shares.photos) {
      for (const SquareShare& square : share.squares) {
        for (int y = 0; y < shares.square_px; ++y) {
          for (int x = 0; x < shares.square_px; ++x) {
            const std::size_t pixel =
                static_cast<std::size_t>(square.y + y) * side + static_cast<std::size_t>(square.x + x);
            const float weight = share.WeightAt(square, square.x + x, square.y + y, shares.square_px);
            EXPECT_GE(weight, 0.0F);
            sums.weight[pixel] += weight;
            sums.photos[pixel] += weight > 0.0F ? 1 : 0;
          }
        }
      }
    }
    return sums;
  }

  static test::SimulatedMap* map_;
  static SeamMap* seams_;
};
test::SimulatedMap* WeighPhotosTest::map_ = nullptr;
SeamMap* WeighPhotosTest::seams_ = nullptr;

TEST_F(WeighPhotosTest, WeightsOfACoveredPixelAddUpToOne) {
  ASSERT_FALSE(map_->plan.blocks.empty());
  std::size_t covered = 0, blended = 0;
  for (const RenderBlock& block : map_->plan.blocks) {
    const Sums sums = SumsOf(Weigh(block).shares);
    for (std::size_t pixel = 0; pixel < sums.weight.size(); ++pixel) {
      if (sums.photos[pixel] == 0) continue;
      ++covered;
      blended += sums.photos[pixel] > 1 ? 1 : 0;
      ASSERT_NEAR(sums.weight[pixel], 1.0F, 1e-4F) << "pixel " << pixel;
    }
  }
  EXPECT_GT(covered, 50'000u);
  EXPECT_GT(blended, 500u);
  EXPECT_LT(blended, covered / 2) << "seams are narrow";
}

// The seam map knows what a photo sees by the middles of its cells; where looks end lies within some of them.
TEST_F(WeighPhotosTest, APhotoShowsNothingPastWhereItsLooksEnd) {
  test::SimulatedMap map = test::MakeSimulatedMap(test::SmallPhotos(12));
  for (alignment::AlignedPhoto& photo : map.flight.photos) photo.max_look_rad = 0.35;
  const SeamMap seams = map.Seams({});
  const std::size_t side = static_cast<std::size_t>(SidePx());
  std::size_t seen = 0, crossed = 0;
  for (const RenderBlock& block : map.plan.blocks) {
    const WeighedBlock weighed =
        WeighBlock(map.flight, map.ground, seams, map.plan, block,
                   MakeBlockGeometry(block.tile, SidePx(), map.flight.frame, map.ground));
    const auto below = static_cast<std::size_t>(weighed.geometry.nodes_per_side);
    const auto nodes_seen = [&](std::size_t place, std::size_t pixel) {
      const std::vector<Eigen::Vector2f>& at = weighed.views[place].pixel_in_image;
      const std::size_t node = pixel / side / kNodeStepPx * below + pixel % side / kNodeStepPx;
      const std::array<std::size_t, 4> around{node, node + 1, node + below, node + below + 1};
      return std::count_if(around.begin(), around.end(),
                           [&](std::size_t k) { return !std::isnan(at[k].x()); });
    };
    std::vector<float> sums(side * side, 0.0F);
    for (const PhotoShare& share : weighed.shares.photos) {
      const auto place = static_cast<std::size_t>(
          std::lower_bound(weighed.photos.begin(), weighed.photos.end(), share.photo) -
          weighed.photos.begin());
      for (const SquareShare& square : share.squares) {
        for (int y = square.y; y < square.y + weighed.shares.square_px; ++y) {
          for (int x = square.x; x < square.x + weighed.shares.square_px; ++x) {
            const std::size_t pixel = static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x);
            const float weight = share.WeightAt(square, x, y, weighed.shares.square_px);
            sums[pixel] += weight;
            if (weight == 0.0F) continue;
            ASSERT_EQ(nodes_seen(place, pixel), 4) << share.photo << " at " << x << ' ' << y;
          }
        }
      }
    }
    for (std::size_t pixel = 0; pixel < sums.size(); ++pixel) {
      if (sums[pixel] > 0.0F) {
        ++seen;
        ASSERT_NEAR(sums[pixel], 1.0F, 1e-4F);
      }
      for (std::size_t place = 0; place < weighed.photos.size(); ++place) {
        const auto corners = nodes_seen(place, pixel);
        crossed += corners > 0 && corners < 4 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(seen, 50'000u);
  EXPECT_GT(crossed, 5'000u);
}

// Houses of 8 x 8 m, 9 m high, every 20 m, and between them hedges of half a metre, 4 m high.
ground::GroundSurface Houses(double ground_z_m) {
  constexpr int kSide = 1200;
  constexpr double kCellM = 0.25;
  std::vector<float> heights_m;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const bool is_house = row % 80 < 32 && column % 80 < 32, is_hedge = row % 80 / 2 == 28;
      heights_m.push_back(static_cast<float>(ground_z_m + (is_house ? 9.0 : is_hedge ? 4.0 : 0.0)));
    }
  }
  return ground::GroundSurface::WithSteps(Eigen::Vector2d::Constant(-0.5 * kSide * kCellM), kCellM, kSide,
                                          kSide, std::move(heights_m), ground_z_m);
}

// By node: whether a photo sees it past the houses.
std::vector<std::uint8_t> SeenBy(const alignment::AlignedPhoto& photo, const BlockGeometry& geometry,
                                 const ground::GroundSurface& houses) {
  const PhotoView view = ViewBlock(photo, geometry);
  const Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
  std::vector<std::uint8_t> seen;
  for (std::size_t node = 0; node < geometry.ground_in_enu.size(); ++node) {
    seen.push_back(photo.intrinsics.IsInImage(view.pixel_in_image[node].cast<double>()) &&
                   !ground::IsOccluded(houses, geometry.ground_in_enu[node], center));
  }
  return seen;
}

TEST_F(WeighPhotosTest, AmongHousesAPhotoThatSeesAPlaceShowsIt) {
  test::SimulatedMap housed = test::MakeSimulatedMap(test::SmallPhotos(12));
  housed.ground = Houses(housed.ground.MeanHeight());
  const SeamMap seams = housed.Seams({});
  std::size_t seen_by_some = 0, told_apart = 0, shown_by_others = 0;
  for (const RenderBlock& block : housed.plan.blocks) {
    const WeighedBlock weighed =
        WeighBlock(housed.flight, housed.ground, seams, housed.plan, block,
                   MakeBlockGeometry(block.tile, SidePx(), housed.flight.frame, housed.ground));
    ASSERT_EQ(weighed.geometry.node_step_px, kNodeStepOverStepsPx);
    const Sums sums = SumsOf(weighed.shares);
    std::vector<std::vector<std::uint8_t>> seen;
    for (const std::uint32_t photo : weighed.photos)
      seen.push_back(SeenBy(housed.flight.photos[photo], weighed.geometry, housed.ground));
    // Of each photo at a pixel.
    const auto side = static_cast<std::size_t>(SidePx());
    std::vector<std::vector<float>> weights(weighed.photos.size(), std::vector<float>(side * side, 0.0F));
    for (const PhotoShare& share : weighed.shares.photos) {
      const auto at = std::lower_bound(weighed.photos.begin(), weighed.photos.end(), share.photo);
      std::vector<float>& own = weights[static_cast<std::size_t>(at - weighed.photos.begin())];
      for (const SquareShare& square : share.squares) {
        for (int y = square.y; y < square.y + weighed.shares.square_px; ++y) {
          for (int x = square.x; x < square.x + weighed.shares.square_px; ++x)
            own[static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x)] =
                share.WeightAt(square, x, y, weighed.shares.square_px);
        }
      }
    }
    const auto below = static_cast<std::size_t>(weighed.geometry.nodes_per_side);
    for (std::size_t row = 0; row + 1 < below; ++row) {
      for (std::size_t column = 0; column + 1 < below; ++column) {
        const std::size_t pixel = kNodeStepOverStepsPx * (row * side + column), node = row * below + column;
        int wholly = 0, not_at_all = 0;
        float of_blind = 0.0F;
        for (std::size_t i = 0; i < seen.size(); ++i) {
          const int corners =
              seen[i][node] + seen[i][node + 1] + seen[i][node + below] + seen[i][node + below + 1];
          wholly += corners == 4 ? 1 : 0;
          not_at_all += corners == 0 ? 1 : 0;
          if (corners == 0) of_blind += weights[i][pixel];
        }
        if (wholly == 0) continue;
        ++seen_by_some;
        ASSERT_NEAR(sums.weight[pixel], 1.0F, 1e-4F) << row << ' ' << column;
        if (not_at_all == 0) continue;
        ++told_apart;
        shown_by_others += of_blind > 0.5F ? 1 : 0;
      }
    }
  }
  EXPECT_GT(seen_by_some, 10'000u);
  EXPECT_GT(told_apart, 5'000u);
  // The seam map tells a cell by 25 of its places.
  EXPECT_LT(shown_by_others, told_apart / 10'000) << told_apart;
}

TEST_F(WeighPhotosTest, GivesSquaresToPhotosOfTheBlockInRisingOrder) {
  for (const RenderBlock& block : map_->plan.blocks) {
    const WeighedBlock weighed = Weigh(block);
    for (std::size_t k = 0; k < weighed.shares.photos.size(); ++k) {
      const PhotoShare& share = weighed.shares.photos[k];
      EXPECT_TRUE(std::binary_search(weighed.photos.begin(), weighed.photos.end(), share.photo));
      if (k > 0) {
        EXPECT_GT(share.photo, weighed.shares.photos[k - 1].photo);
      }
    }
  }
}

}  // namespace
}  // namespace skyquilt::render
