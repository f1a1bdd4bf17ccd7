#include "core/pipeline/surface/trust_heights.h"

#include <algorithm>
#include <cstddef>

#include "core/pipeline/surface/choose_ground.h"

namespace skyquilt::pipeline {
namespace {

constexpr int kFadeSquares = 6, kSquaresAround = 2;
// Of two thirds a shining car at the rim of Brighton stays whole, of half it does not.
constexpr float kMeasuredByTwo = 2.0f / 3.0f;

}  // namespace

std::vector<float> MeasuredAround(const surface::SurfaceGrid& grid,
                                  const std::vector<std::uint8_t>& agreeing_photos, int columns, int rows) {
  std::vector<int> measured(static_cast<std::size_t>(columns) * rows, 0), cells = measured;
  std::size_t cell = 0;
  for (int row = 0; row < grid.rows; ++row) {
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(row / kTrustSquareCells) * columns;
    for (int column = 0; column < grid.columns; ++column, ++cell) {
      const auto square = static_cast<std::size_t>(first + column / kTrustSquareCells);
      measured[square] += agreeing_photos[cell] != 0 ? 1 : 0;
      ++cells[square];
    }
  }
  std::vector<float> shares;
  shares.reserve(measured.size());
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      int sum = 0, count = 0;
      for (int y = std::max(0, row - kSquaresAround); y <= std::min(rows - 1, row + kSquaresAround); ++y) {
        for (int x = std::max(0, column - kSquaresAround);
             x <= std::min(columns - 1, column + kSquaresAround); ++x) {
          sum += measured[static_cast<std::size_t>(y) * columns + x];
          count += cells[static_cast<std::size_t>(y) * columns + x];
        }
      }
      shares.push_back(static_cast<float>(sum) / static_cast<float>(std::max(count, 1)));
    }
  }
  return shares;
}

std::vector<float> TrustHeights(const std::vector<std::uint8_t>& photos, const std::vector<float>& measured,
                                int columns, int rows) {
  std::vector<float> trust(photos.size());
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const bool is_borne_out = photos[i] >= kPhotosThatBearOut ||
                              (photos[i] + 1 == kPhotosThatBearOut && measured[i] >= kMeasuredByTwo);
    trust[i] = is_borne_out ? 1.0f : 0.0f;
  }
  // No square more than 1 / kFadeSquares above those beside it.
  const auto lower = [&](int row, int column, int other_row, int other_column) {
    if (other_row < 0 || other_column < 0 || other_row >= rows || other_column >= columns) return;
    float& here = trust[static_cast<std::size_t>(row) * columns + column];
    here = std::min(
        here, trust[static_cast<std::size_t>(other_row) * columns + other_column] + 1.0f / kFadeSquares);
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      for (const int side : {-1, 0, 1}) lower(row, column, row - 1, column + side);
      lower(row, column, row, column - 1);
    }
  }
  for (int row = rows - 1; row >= 0; --row) {
    for (int column = columns - 1; column >= 0; --column) {
      for (const int side : {-1, 0, 1}) lower(row, column, row + 1, column + side);
      lower(row, column, row, column + 1);
    }
  }
  return trust;
}

}  // namespace skyquilt::pipeline
