#include "core/render/blocks/block_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/ground/ground_surface.h"
#include "core/render/blocks/weigh_block.h"
#include "tests/support/simulated_map.h"

namespace skyquilt::render {
namespace {

class WeighPhotosTest : public testing::Test {
 protected:
  static simulate::SimulateOptions Options() {
    simulate::SimulateOptions options;
    options.intrinsics = camera::Intrinsics::Centered(480, 360, 360.0);
    options.trajectory.photos = 12;
    return options;
  }
  static void SetUpTestSuite() {
    map_ = new test::SimulatedMap(test::MakeSimulatedMap(Options()));
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
  test::SimulatedMap housed = test::MakeSimulatedMap(Options());
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
