#include "core/alignment/from_records/flight_lines.h"

#include <algorithm>
#include <cmath>

#include "core/base/median.h"

namespace skyquilt::alignment {

std::vector<int> FindLines(const std::vector<Eigen::Vector2d>& east_north) {
  constexpr double kCosineOfTurn = 0.82;  // 35 degrees
  constexpr double kGap = 4.0;
  std::vector<int> lines(east_north.size(), 0);
  if (east_north.size() < 3) return lines;
  std::vector<double> spacings;
  for (std::size_t i = 1; i < east_north.size(); ++i) {
    spacings.push_back((east_north[i] - east_north[i - 1]).norm());
  }
  const double usual = Median(spacings);
  int line = 0;
  std::size_t start = 0;
  for (std::size_t i = 1; i < east_north.size(); ++i) {
    const double spacing = spacings[i - 1];
    bool ends = spacing > kGap * usual;
    if (!ends && i - start >= 2 && spacing > 0.2 * usual) {
      // Against the line's course so far, not only its last step: noise in positions must not end it.
      const std::size_t from = i - start > 4 ? i - 4 : start;
      const Eigen::Vector2d course = east_north[i - 1] - east_north[from];
      const double length = course.norm();
      ends =
          length > 1e-6 && course.dot(east_north[i] - east_north[i - 1]) < kCosineOfTurn * length * spacing;
    }
    if (ends) {
      ++line;
      start = i;
    }
    lines[i] = line;
  }
  return lines;
}

}  // namespace skyquilt::alignment
