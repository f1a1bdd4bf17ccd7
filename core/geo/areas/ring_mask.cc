#include "core/geo/areas/ring_mask.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::geo {

void MaskRings(const std::vector<RingEdge>& edges, const MaskWindow& window,
               std::vector<std::uint8_t>& inside) {
  // The first row or column whose middle lies at or beyond a place, counted from the window's corner.
  const auto first_from = [](double place, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(std::ceil(place - 0.5), 0.0, static_cast<double>(count)));
  };
  std::vector<std::vector<double>> crossings(window.rows);
  for (const RingEdge& edge : edges) {
    const std::size_t end = first_from(std::max(edge.y0, edge.y1) - window.top, window.rows);
    for (std::size_t row = first_from(std::min(edge.y0, edge.y1) - window.top, window.rows); row < end;
         ++row) {
      const double y = window.top + static_cast<double>(row) + 0.5;
      crossings[row].push_back(edge.x0 + (y - edge.y0) / (edge.y1 - edge.y0) * (edge.x1 - edge.x0));
    }
  }
  for (std::size_t row = 0; row < window.rows; ++row) {
    std::vector<double>& of_row = crossings[row];
    std::sort(of_row.begin(), of_row.end());
    const auto begin = inside.begin() + static_cast<std::ptrdiff_t>(row * window.columns);
    for (std::size_t i = 0; i + 1 < of_row.size(); i += 2) {
      std::fill(begin + static_cast<std::ptrdiff_t>(first_from(of_row[i] - window.left, window.columns)),
                begin + static_cast<std::ptrdiff_t>(first_from(of_row[i + 1] - window.left, window.columns)),
                std::uint8_t{1});
    }
  }
}

}  // namespace skyquilt::geo
