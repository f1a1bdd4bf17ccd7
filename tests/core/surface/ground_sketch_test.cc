#include "core/surface/terrain/ground_sketch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace skyquilt::surface {
namespace {

constexpr int kWide = 600, kHigh = 400;
constexpr double kFineCellM = 0.1;
constexpr double kAboveSeaM = 1800.0;  // where a float knows a tenth of a millimetre

bool IsHouse(int column, int row) { return column >= 200 && column < 320 && row >= 100 && row < 220; }
// A kerb: finer than the sketch.
bool IsRaised(int column, int row) { return column >= 450 && column < 453 && row > 50; }

double GroundAt(int column, int row) { return kAboveSeaM + 0.004 * column + 0.2 * std::sin(row / 60.0); }

float HeightAt(int column, int row) {
  return static_cast<float>(GroundAt(column, row) + (IsHouse(column, row) ? 5.0 : 0.0) +
                            (IsRaised(column, row) ? 0.1 : 0.0));
}

std::vector<float> HeightsOf(const CellBox& box) {
  std::vector<float> heights;
  for (int row = box.row; row < box.row + box.rows; ++row) {
    for (int column = box.column; column < box.column + box.columns; ++column)
      heights.push_back(row < 10 ? std::numeric_limits<float>::quiet_NaN() : HeightAt(column, row));
  }
  return heights;
}

std::vector<std::uint8_t> PhotosOf(const std::vector<float>& heights) {
  std::vector<std::uint8_t> photos;
  for (const float height : heights) photos.push_back(std::isnan(height) ? 0 : 3);
  return photos;
}

std::vector<CellBox> Parts() {
  std::vector<CellBox> parts;
  for (int row = 0; row < kHigh; row += 130) {
    for (int column = 0; column < kWide; column += 170)
      parts.push_back({column, row, std::min(170, kWide - column), std::min(130, kHigh - row)});
  }
  return parts;
}

TEST(GroundSketch, BridgesHousesAndLeavesTheGroundAsFineAsItIs) {
  GroundSketch sketch(kWide, kHigh, kFineCellM);
  for (const CellBox& part : Parts()) sketch.Add(part, HeightsOf(part), PhotosOf(HeightsOf(part)));
  sketch.Finish();
  for (const CellBox& part : Parts()) {
    const std::vector<float> heights = HeightsOf(part);
    const GroundModel ground = sketch.GroundOf(part, heights, PhotosOf(heights));
    std::size_t cell = 0;
    for (int row = part.row; row < part.row + part.rows; ++row) {
      for (int column = part.column; column < part.column + part.columns; ++column, ++cell) {
        if (row < 10) {
          EXPECT_TRUE(std::isnan(ground.heights_m[cell]));
          EXPECT_EQ(ground.is_ground[cell], 0);
        } else if (IsHouse(column, row)) {
          EXPECT_NEAR(ground.heights_m[cell], GroundAt(column, row), 0.15) << column << " " << row;
          EXPECT_EQ(ground.is_ground[cell], 0);
        } else {
          EXPECT_EQ(ground.heights_m[cell], heights[cell]) << column << " " << row;
          EXPECT_EQ(ground.is_ground[cell], 1);
        }
      }
    }
  }
}

TEST(GroundSketch, TakesOneCellAndNone) {
  GroundSketch one(1, 1, 0.1);
  one.Add({0, 0, 1, 1}, {7.0f}, {2});
  one.Finish();
  EXPECT_EQ(one.GroundOf({0, 0, 1, 1}, {7.0f}, {2}).heights_m, std::vector<float>{7.0f});
  GroundSketch none(3, 2, 0.1);
  none.Add({0, 0, 3, 1}, {5.0f, 5.0f, 5.0f}, {0, 0, 0});
  none.Finish();
  EXPECT_EQ(none.GroundOf({0, 0, 1, 1}, {5.0f}, {0}).heights_m, std::vector<float>{5.0f}) << "not measured";
  const std::vector<float> unseen(6, std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(std::isnan(none.GroundOf({0, 0, 3, 2}, unseen, PhotosOf(unseen)).heights_m[5]));
}

TEST(GroundSketch, BelievesWhatWasMeasuredBeforeWhatWasFilled) {
  GroundSketch sketch(100, 100, 0.1);
  const CellBox all{0, 0, 100, 100};
  std::vector<float> heights(all.Count(), 2.0f);
  std::vector<std::uint8_t> photos(all.Count(), 4);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (i % 3 == 0) heights[i] = -3.0f, photos[i] = 0;
  }
  sketch.Add(all, heights, photos);
  sketch.Finish();
  const GroundModel ground = sketch.GroundOf(all, heights, photos);
  for (std::size_t i = 0; i < all.Count(); ++i) {
    EXPECT_NEAR(ground.heights_m[i], 2.0f, 1e-3f);
    EXPECT_EQ(ground.is_ground[i], photos[i] == 0 ? 0 : 1);
  }
}

}  // namespace
}  // namespace skyquilt::surface
