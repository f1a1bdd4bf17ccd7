// BilinearAt: a grid of numbers read between its nodes; outside it goes on with its border. What
// is not a number lies in the first row or column. Pure; any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace skyquilt {

// `values` row by row, at least 2 x 2; x and y count nodes from the first.
inline double BilinearAt(const std::vector<float>& values, int columns, int rows, double x, double y) {
  x = std::max(0.0, std::min(x, columns - 1.0));
  y = std::max(0.0, std::min(y, rows - 1.0));
  const int column = std::min(static_cast<int>(x), columns - 2);
  const int row = std::min(static_cast<int>(y), rows - 2);
  const double u = x - column, v = y - row;
  const float* node = values.data() + static_cast<std::size_t>(row) * columns + column;
  return (1.0 - v) * ((1.0 - u) * node[0] + u * node[1]) +
         v * ((1.0 - u) * node[columns] + u * node[columns + 1]);
}

}  // namespace skyquilt
