#include "core/render/seams/moving_objects.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace skyquilt::render {
namespace {

constexpr int kSide = 60;
constexpr double kCellM = 0.8;
using Colour = std::array<std::uint8_t, 3>;
constexpr Colour kRed{190, 30, 30};

// Two views of the same meadow, a little brighter from one side; their cameras stood far left and far right.
class MovingObjects : public testing::Test {
 protected:
  MovingObjects() {
    for (int i = 0; i < 2; ++i) {
      LowResView& view = views_[static_cast<std::size_t>(i)];
      view.columns = view.rows = kSide;
      view.camera_east_m = i == 0 ? 0.0f : static_cast<float>(kSide * kCellM);
      view.seen.assign(kSide * kSide, Seen::kFully);
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const int grass = 90 + (x * 7 + y * 13) % 9 + 8 * i;
          view.rgb.push_back(
              {static_cast<std::uint8_t>(grass), static_cast<std::uint8_t>(grass + 20), std::uint8_t{60}});
        }
      }
    }
  }
  void Paint(std::size_t view, int x, int y, int width, int height, const Colour& colour = kRed) {
    for (int row = y; row < y + height; ++row) {
      for (int column = x; column < x + width; ++column)
        views_[view].rgb[static_cast<std::size_t>(row * kSide + column)] = colour;
    }
  }
  int Marked(std::size_t view) {
    MarkMoving(views_, kCellM, 1);
    int cells = 0;
    for (const bool is_marked : views_[view].is_moving) cells += is_marked ? 1 : 0;
    return cells;
  }
  bool IsMarked(std::size_t view, int x, int y) const {
    return views_[view].is_moving[static_cast<std::size_t>(y * kSide + x)];
  }

  std::vector<LowResView> views_{2};
};

TEST_F(MovingObjects, AreMarkedWholeWithTheirRimWhereTheyAre) {
  Paint(0, 20, 30, 6, 3);
  EXPECT_EQ(Marked(0), 8 * 5);
  EXPECT_EQ(Marked(1), 0);
  EXPECT_TRUE(IsMarked(0, 19, 29));
  EXPECT_TRUE(IsMarked(0, 26, 33));
  EXPECT_FALSE(IsMarked(0, 18, 30));
}

TEST_F(MovingObjects, AreMarkedInBothViewsThatShowThemElsewhere) {
  Paint(0, 30, 10, 6, 3);
  Paint(1, 28, 45, 3, 6);
  EXPECT_EQ(Marked(0), 8 * 5);
  EXPECT_EQ(Marked(1), 5 * 8);
}

TEST_F(MovingObjects, ThatMovedByLessThanTheirLengthAreLeftToOneView) {
  Paint(0, 20, 30, 6, 3);
  Paint(1, 23, 30, 6, 3);
  EXPECT_EQ(Marked(0), 0);
  EXPECT_EQ(Marked(1), 0);
}

TEST_F(MovingObjects, AreNotThingsThatLeanAwayFromTheCameras) {
  Paint(0, 34, 30, 2, 2);
  Paint(1, 26, 30, 2, 2);
  EXPECT_EQ(Marked(0), 0);
  EXPECT_EQ(Marked(1), 0);
}

TEST_F(MovingObjects, AreNotShadowsOfCloudsNorLight) {
  Paint(0, 10, 10, 40, 40, {40, 50, 30});
  EXPECT_EQ(Marked(0), 0);
  EXPECT_EQ(Marked(1), 0);
}

TEST_F(MovingObjects, AreNotKnownWhereOneViewEnds) {
  Paint(0, 20, 30, 6, 3);
  for (int y = 0; y < kSide; ++y) views_[1].seen[static_cast<std::size_t>(y * kSide + 27)] = Seen::kPartly;
  EXPECT_EQ(Marked(0), 0);
}

TEST_F(MovingObjects, AreTheSameWithAnyNumberOfThreads) {
  Paint(0, 20, 30, 6, 3);
  views_.push_back(views_[1]);
  views_.push_back(views_[0]);
  std::vector<LowResView> others = views_;
  MarkMoving(views_, kCellM, 1);
  MarkMoving(others, kCellM, 3);
  for (std::size_t i = 0; i < views_.size(); ++i) EXPECT_EQ(views_[i].is_moving, others[i].is_moving);
}

}  // namespace
}  // namespace skyquilt::render
