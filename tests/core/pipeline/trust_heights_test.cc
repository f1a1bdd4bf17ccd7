#include "core/pipeline/surface/trust_heights.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace skyquilt::pipeline {
namespace {

constexpr int kSquares = 21;

std::vector<std::uint8_t> SeenBy(std::uint8_t photos) {
  return std::vector<std::uint8_t>(static_cast<std::size_t>(kSquares) * kSquares, photos);
}

std::vector<float> Measured(float share) {
  return std::vector<float>(static_cast<std::size_t>(kSquares) * kSquares, share);
}

TEST(TrustHeights, ThreePhotosAreEnoughAndTwoWhereMostWasMeasured) {
  const auto all = [](const std::vector<float>& trust, float expected) {
    for (const float one : trust) ASSERT_EQ(one, expected);
  };
  all(TrustHeights(SeenBy(3), Measured(0.1f), kSquares, kSquares), 1.0f);
  all(TrustHeights(SeenBy(2), Measured(0.9f), kSquares, kSquares), 1.0f);
  all(TrustHeights(SeenBy(2), Measured(0.5f), kSquares, kSquares), 0.0f);
  all(TrustHeights(SeenBy(1), Measured(0.9f), kSquares, kSquares), 0.0f);
}

TEST(TrustHeights, FadesTowardsWhatIsNotBorneOut) {
  std::vector<std::uint8_t> photos = SeenBy(3);
  photos[10 * kSquares + 10] = 1;
  const std::vector<float> trust = TrustHeights(photos, Measured(1.0f), kSquares, kSquares);
  EXPECT_EQ(trust[10 * kSquares + 10], 0.0f);
  EXPECT_FLOAT_EQ(trust[10 * kSquares + 11], 1.0f / 6.0f);
  EXPECT_FLOAT_EQ(trust[7 * kSquares + 10], 0.5f);
  EXPECT_FLOAT_EQ(trust[13 * kSquares + 13], 0.5f);
  EXPECT_EQ(trust[10 * kSquares + 17], 1.0f);
}

TEST(MeasuredAround, CountsCellsOfTheSquareAndOfThoseBeside) {
  constexpr int kCells = 7 * kTrustSquareCells;
  const surface::SurfaceGrid grid{{0.0, 0.0}, 0.1, kCells, kCells};
  std::vector<std::uint8_t> agreeing(static_cast<std::size_t>(kCells) * kCells, 0);
  for (int row = 0; row < kTrustSquareCells; ++row) {
    for (int column = 0; column < kTrustSquareCells; ++column)
      agreeing[static_cast<std::size_t>(row) * kCells + column] = 2;
  }
  for (int row = kCells - 8; row < kCells; ++row)
    std::fill_n(agreeing.begin() + static_cast<std::ptrdiff_t>(row) * kCells, kCells, std::uint8_t{3});
  const std::vector<float> shares = MeasuredAround(grid, agreeing, 8, 8);
  EXPECT_FLOAT_EQ(shares[0], 1.0f / 9.0f);  // of three by three: the others would lie outside
  EXPECT_FLOAT_EQ(shares[2 * 8 + 2], 1.0f / 25.0f);
  EXPECT_EQ(shares[3], 0.0f);
  EXPECT_FLOAT_EQ(shares[6 * 8 + 6], 0.5f / 3.0f);  // and so at the other end
  EXPECT_FLOAT_EQ(shares[7 * 8 + 7], 0.5f / 2.0f);  // of a square without cells: those beside it
}

}  // namespace
}  // namespace skyquilt::pipeline
