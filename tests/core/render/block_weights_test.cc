#include "core/render/blocks/block_weights.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/render/blocks/weigh_block.h"
#include "tests/support/simulated_map.h"

namespace skyquilt::render {
namespace {

class WeighPhotosTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    simulate::SimulateOptions options;
    options.intrinsics = camera::Intrinsics::Centered(480, 360, 360.0);
    options.trajectory.photos = 12;
    map_ = new test::SimulatedMap(test::MakeSimulatedMap(options));
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
            const float weight =
                square.first_weight == SquareShare::kAlone
                    ? 1.0F
                    : share.weights[static_cast<std::size_t>(square.first_weight + y * shares.square_px + x)];
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
