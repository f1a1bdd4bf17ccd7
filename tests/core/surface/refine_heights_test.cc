#include "core/surface/refine/refine_heights.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/surface/refine/alike_heights.h"
#include "core/surface/refine/edge_heights.h"

namespace skyquilt::surface {
namespace {

constexpr int kSide = 40;

LevelHeights Level(float height_m) {
  const std::size_t cells = static_cast<std::size_t>(kSide) * kSide;
  return {kSide, kSide, std::vector<float>(cells, height_m), std::vector<std::uint8_t>(cells, 1)};
}

void Raise(LevelHeights& level, int column, int row, int columns, int rows, float height_m) {
  for (int y = row; y < row + rows; ++y) {
    for (int x = column; x < column + columns; ++x) level.heights_m[level.IndexOf(x, y)] = height_m;
  }
}

TEST(CountAlike, CountsTheCellsAroundWithinABound) {
  LevelHeights level = Level(2.0f);
  level.heights_m[level.IndexOf(20, 20)] = 2.6f;
  level.heights_m[level.IndexOf(22, 20)] = 2.4f;
  const auto alike = CountAlike(level, 0.5f);
  EXPECT_EQ(alike[level.IndexOf(10, 10)], kMaxAlike);
  EXPECT_EQ(alike[level.IndexOf(20, 20)], 1);
  EXPECT_EQ(alike[level.IndexOf(18, 20)], kMaxAlike - 1);
  EXPECT_EQ(alike[0], 15);  // a corner
  EXPECT_EQ(CountAlike(Level(-900.0f), 0.5f)[level.IndexOf(10, 10)], kMaxAlike);
}

TEST(CountAlike, TellsHeightsFarApartFromEqualOnes) {
  LevelHeights level = Level(0.0f);
  level.heights_m[level.IndexOf(20, 20)] = 1e6f;
  level.heights_m[level.IndexOf(30, 20)] = -1e6f;
  const auto alike = CountAlike(level, 0.01f);
  EXPECT_EQ(alike[level.IndexOf(20, 20)], 0);
  EXPECT_EQ(alike[level.IndexOf(30, 20)], 0);
}

constexpr SpeckleRules kRules{0.5f, 33, 17, 20, 200, 10, 44};

// That so many photos agree on every cell.
std::vector<std::uint8_t> Agreeing(std::uint8_t photos) {
  return std::vector<std::uint8_t>(kSide * kSide, photos);
}

TEST(DropSpeckles, DropsWhatStandsAlone) {
  LevelHeights level = Level(0.0f);
  Raise(level, 5, 10, 3, 3, 5.0f);
  Raise(level, 20, 10, 12, 12, 5.0f);
  DropSpeckles(level, CountAlike(level, 0.5f), Agreeing(3), kRules);
  EXPECT_EQ(level.is_known[level.IndexOf(6, 11)], 0);
  EXPECT_EQ(level.is_known[level.IndexOf(26, 16)], 1);
  EXPECT_EQ(level.is_known[level.IndexOf(20, 16)], 1) << "an edge hangs on to its roof";
  EXPECT_EQ(level.is_known[level.IndexOf(15, 35)], 1);
}

TEST(DropSpeckles, DropsHeightsThatStrayFromCellToCell) {
  LevelHeights level = Level(0.0f);
  std::uint32_t random = 7;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide / 2; ++column) {
      random = random * 1664525U + 1013904223U;
      level.heights_m[level.IndexOf(column, row)] = static_cast<float>(random >> 28) * 0.4f;
    }
  }
  DropSpeckles(level, CountAlike(level, 0.5f), Agreeing(3), kRules);
  int known = 0;
  for (int row = 4; row < kSide - 4; ++row) {
    for (int column = 4; column < kSide / 2 - 4; ++column)
      known += level.is_known[level.IndexOf(column, row)];
    EXPECT_EQ(level.is_known[level.IndexOf(30, row)], 1);
  }
  EXPECT_EQ(known, 0);
}

TEST(DropSpeckles, WantsMoreOfASurfaceThatTwoPhotosAloneShow) {
  for (const std::uint8_t photos : {2, 3}) {
    LevelHeights level = Level(0.0f);
    Raise(level, 20, 10, 12, 8, 5.0f);  // 40 cells of its own, ragged for being so small
    DropSpeckles(level, CountAlike(level, 0.5f), Agreeing(photos), kRules);
    EXPECT_EQ(level.is_known[level.IndexOf(26, 14)], photos == 3 ? 1 : 0) << int{photos};
    EXPECT_EQ(level.is_known[level.IndexOf(15, 35)], 1) << "the ground is large";
  }
}

TEST(FillUnknown, TakesTheLowerSideOfAWall) {
  LevelHeights level = Level(1.0f);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 20; column < kSide; ++column) level.heights_m[level.IndexOf(column, row)] = 9.0f;
    for (int column = 16; column < 20; ++column) level.is_known[level.IndexOf(column, row)] = 0;
  }
  FillUnknown(level, std::vector<float>(level.heights_m.size(), -7.0f), 12, 0.5f);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(18, 20)], 1.0f);
  EXPECT_EQ(level.is_known[level.IndexOf(18, 20)], 0);
}

TEST(FillUnknown, TakesWhatIsExpectedFarFromAllThatIsKnown) {
  LevelHeights level = Level(1.0f);
  std::fill(level.is_known.begin(), level.is_known.end(), std::uint8_t{0});
  level.is_known[level.IndexOf(0, 0)] = 1;
  FillUnknown(level, std::vector<float>(level.heights_m.size(), -7.0f), 12, 0.5f);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(0, 0)], 1.0f);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(1, 1)], -7.0f);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(30, 30)], -7.0f);
}

TEST(TakeMedians, EvensOutSingleCellsAndKeepsSteps) {
  LevelHeights level = Level(1.0f);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 20; column < kSide; ++column) level.heights_m[level.IndexOf(column, row)] = 9.0f;
  }
  level.heights_m[level.IndexOf(8, 8)] = 4.0f;
  TakeMedians(level);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(8, 8)], 1.0f);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(19, 8)], 1.0f);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(20, 8)], 9.0f);
}

TEST(MeansAround, AreThoseOfFiveByFive) {
  std::vector<std::uint8_t> values(static_cast<std::size_t>(kSide) * kSide, 10);
  values[5 * kSide + 5] = 110;
  const auto means = MeansAround(values, kSide, kSide);
  EXPECT_EQ(means[0], 10);
  EXPECT_EQ(means[7 * kSide + 7], 14);
  EXPECT_EQ(means[8 * kSide + 7], 10);
}

// Heights step at column 18, the picture at 20.
LevelHeights Stepped(std::vector<std::uint8_t>& gray) {
  LevelHeights level = Level(1.0f);
  gray.assign(level.heights_m.size(), 40);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 18; column < kSide; ++column) level.heights_m[level.IndexOf(column, row)] = 9.0f;
    for (int column = 20; column < kSide; ++column) gray[level.IndexOf(column, row)] = 160;
  }
  return level;
}

TEST(TakeBetterSides, MovesAStepToThePicturesEdge) {
  std::vector<std::uint8_t> gray;
  LevelHeights level = Stepped(gray);
  const OtherSides sides = FindOtherSides(level, gray, 0.5f);
  EXPECT_FLOAT_EQ(sides.heights_m[level.IndexOf(5, 20)], 1.0f);
  EXPECT_FLOAT_EQ(sides.heights_m[level.IndexOf(19, 20)], 1.0f);
  EXPECT_FLOAT_EQ(sides.heights_m[level.IndexOf(17, 20)], 9.0f);
  TakeBetterSides(sides, std::vector<std::int16_t>(level.heights_m.size(), 0), level);
  for (int row = 10; row < 30; ++row) {
    EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(5, row)], 1.0f);
    EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(19, row)], 1.0f);
    EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(20, row)], 9.0f);
  }
}

TEST(TakeBetterSides, BelievesPhotosThatComparedBothHeights) {
  std::vector<std::uint8_t> gray;
  LevelHeights level = Stepped(gray);
  const OtherSides sides = FindOtherSides(level, gray, 0.5f);
  // Photos say that the heights are right as they are.
  TakeBetterSides(sides, std::vector<std::int16_t>(level.heights_m.size(), 40), level);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(18, 20)], 9.0f);
  // Or that all lies on the other side.
  TakeBetterSides(sides, std::vector<std::int16_t>(level.heights_m.size(), -40), level);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(18, 20)], 1.0f);
  EXPECT_FLOAT_EQ(level.heights_m[level.IndexOf(17, 20)], 9.0f);
}

}  // namespace
}  // namespace skyquilt::surface
