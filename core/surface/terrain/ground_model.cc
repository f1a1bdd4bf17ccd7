#include "core/surface/terrain/ground_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/check.h"

namespace skyquilt::surface {
namespace {

constexpr double kWidestThingM = 60.0;  // what is wider than this counts as ground
constexpr double kSlope = 0.3;          // that ground may have
constexpr double kMinHeightM = 0.3;     // what stands less high than this is ground
constexpr double kMaxStepM = 2.5;       // what stands higher is none, however wide the square
constexpr double kMinPitM = 1.0;        // deeper within a few cells: no ground either, but a mistake
constexpr int kPitReach = 2;            // cells: a pit is no wider than twice that and one

// The least (or greatest) of 2 * reach + 1 values about each, by two running ones that begin anew every
// window (van Herk 1992): as many steps for any reach.
template <typename Choose>
void ChooseAlong(std::vector<float>& line, int reach, const Choose& choose, std::vector<float>& padded,
                 std::vector<float>& forward) {
  const std::size_t count = line.size(), window = 2 * static_cast<std::size_t>(reach) + 1;
  const std::size_t length = (count + 2 * static_cast<std::size_t>(reach) + window - 1) / window * window;
  padded.assign(length, line.back());
  std::fill_n(padded.begin(), reach, line.front());
  std::copy(line.begin(), line.end(), padded.begin() + reach);
  forward = padded;
  for (std::size_t i = 1; i < length; ++i) {
    if (i % window != 0) forward[i] = choose(forward[i - 1], forward[i]);
  }
  for (std::size_t i = length - 1; i-- > 0;) {
    if ((i + 1) % window != 0) padded[i] = choose(padded[i], padded[i + 1]);
  }
  for (std::size_t i = 0; i < count; ++i) line[i] = choose(padded[i], forward[i + window - 1]);
}

template <typename Choose>
void ChooseInSquares(std::vector<float>& heights, int columns, int rows, int reach, const Choose& choose) {
  std::vector<float> line, padded, forward;
  for (int row = 0; row < rows; ++row) {
    const auto first = heights.begin() + static_cast<std::ptrdiff_t>(row) * columns;
    line.assign(first, first + columns);
    ChooseAlong(line, reach, choose, padded, forward);
    std::copy(line.begin(), line.end(), first);
  }
  line.resize(static_cast<std::size_t>(rows));
  for (int column = 0; column < columns; ++column) {
    for (int row = 0; row < rows; ++row) {
      line[static_cast<std::size_t>(row)] = heights[static_cast<std::size_t>(row) * columns + column];
    }
    ChooseAlong(line, reach, choose, padded, forward);
    for (int row = 0; row < rows; ++row) {
      heights[static_cast<std::size_t>(row) * columns + column] = line[static_cast<std::size_t>(row)];
    }
  }
}

// Means of the ground in cells twice as large, and so on; from the largest back, cells without ground take
// what lies between those of the larger ones.
void BridgeGaps(std::vector<float>& heights, std::vector<float> weights, int columns, int rows) {
  if (std::all_of(weights.begin(), weights.end(), [](float weight) { return weight > 0.0f; })) return;
  if (columns == 1 && rows == 1) return;
  const int half_columns = (columns + 1) / 2, half_rows = (rows + 1) / 2;
  std::vector<float> half(static_cast<std::size_t>(half_columns) * half_rows, 0.0f),
      half_weights(half.size(), 0.0f);
  const auto half_of = [&](int column, int row) {
    return static_cast<std::size_t>(row / 2) * half_columns + column / 2;
  };
  std::size_t cell = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column, ++cell) {
      half[half_of(column, row)] += weights[cell] * heights[cell];
      half_weights[half_of(column, row)] += weights[cell];
    }
  }
  for (std::size_t i = 0; i < half.size(); ++i) {
    if (half_weights[i] > 0.0f) half[i] /= half_weights[i];
    half_weights[i] = std::min(half_weights[i], 1.0f);
  }
  BridgeGaps(half, half_weights, half_columns, half_rows);
  cell = 0;
  for (int row = 0; row < rows; ++row) {
    const float y =
        std::clamp(0.5f * static_cast<float>(row) - 0.25f, 0.0f, static_cast<float>(half_rows - 1));
    const int low = static_cast<int>(y), high = std::min(low + 1, half_rows - 1);
    const float v = y - static_cast<float>(low);
    for (int column = 0; column < columns; ++column, ++cell) {
      if (weights[cell] > 0.0f) continue;
      const float x =
          std::clamp(0.5f * static_cast<float>(column) - 0.25f, 0.0f, static_cast<float>(half_columns - 1));
      const int left = static_cast<int>(x), right = std::min(left + 1, half_columns - 1);
      const float u = x - static_cast<float>(left);
      const float* below = half.data() + static_cast<std::size_t>(low) * half_columns;
      const float* above = half.data() + static_cast<std::size_t>(high) * half_columns;
      heights[cell] = (1.0f - v) * ((1.0f - u) * below[left] + u * below[right]) +
                      v * ((1.0f - u) * above[left] + u * above[right]);
    }
  }
}

// Between two pits that no ground has, all that there is would stand on them.
void TakePitsAway(GroundModel& ground, int columns, int rows) {
  std::vector<float> closed = ground.heights_m;
  constexpr float kNone = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (ground.is_ground[i] == 0) closed[i] = -kNone;
  }
  ChooseInSquares(closed, columns, rows, kPitReach, [](float a, float b) { return std::max(a, b); });
  for (float& height : closed) height = height == -kNone ? kNone : height;
  ChooseInSquares(closed, columns, rows, kPitReach, [](float a, float b) { return std::min(a, b); });
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (ground.is_ground[i] != 0 && closed[i] - ground.heights_m[i] > kMinPitM) ground.is_ground[i] = 0;
  }
}

// By small steps: the wider the step from one square to the next, the more ground may climb meanwhile, and
// the lower an eave that passes for ground.
int NextReach(int reach) { return std::max(reach + 1, static_cast<int>(1.2 * reach)); }

}  // namespace

GroundModel GroundUnder(const std::vector<float>& heights_m, int columns, int rows, double cell_m) {
  SKYQUILT_CHECK(
      columns > 0 && rows > 0 && cell_m > 0.0 && heights_m.size() == static_cast<std::size_t>(columns) * rows,
      "a ground model needs a grid of heights");
  GroundModel ground{heights_m, std::vector<std::uint8_t>(heights_m.size(), 1)};
  for (std::size_t i = 0; i < heights_m.size(); ++i) {
    if (!std::isnan(heights_m[i])) continue;
    ground.heights_m[i] = 0.0f;
    ground.is_ground[i] = 0;
  }
  if (std::count(ground.is_ground.begin(), ground.is_ground.end(), 1) == 0)
    return {heights_m, ground.is_ground};
  TakePitsAway(ground, columns, rows);
  // From here on a height everywhere, so that nothing stands out where the photos end.
  BridgeGaps(ground.heights_m, {ground.is_ground.begin(), ground.is_ground.end()}, columns, rows);
  std::vector<float> opened = ground.heights_m;
  const int largest =
      std::min(std::max(columns, rows),
               static_cast<int>(std::ceil(0.5 * std::min(kWidestThingM, 1e5 * cell_m) / cell_m)));
  int before = 0;
  for (int reach = 1; before < largest;
       before = reach, reach = std::min(NextReach(reach), std::max(largest, 1))) {
    const std::vector<float> last = opened;
    ChooseInSquares(opened, columns, rows, reach, [](float a, float b) { return std::min(a, b); });
    ChooseInSquares(opened, columns, rows, reach, [](float a, float b) { return std::max(a, b); });
    const double climb_m = kSlope * 2.0 * (reach - before) * cell_m;
    const float most_m = static_cast<float>(std::min(kMaxStepM, kMinHeightM + climb_m));
    for (std::size_t i = 0; i < opened.size(); ++i) {
      if (last[i] - opened[i] > most_m) ground.is_ground[i] = 0;
    }
  }
  // Walls are blurred, and cells at them show some of both: what is beside no ground is not believed either.
  std::vector<float> weights(ground.is_ground.begin(), ground.is_ground.end());
  ChooseInSquares(weights, columns, rows, 1, [](float a, float b) { return std::min(a, b); });
  // Where that leaves nothing far and wide, as between rows of plants, it is all that is known of the ground.
  std::vector<float> near_sure = weights;
  ChooseInSquares(near_sure, columns, rows, largest, [](float a, float b) { return std::max(a, b); });
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (near_sure[i] == 0.0f) weights[i] = static_cast<float>(ground.is_ground[i]);
  }
  BridgeGaps(ground.heights_m, std::move(weights), columns, rows);
  return ground;
}

}  // namespace skyquilt::surface
