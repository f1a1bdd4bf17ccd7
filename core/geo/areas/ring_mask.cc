#include "core/geo/areas/ring_mask.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::geo {

void MaskRings(const std::vector<RingEdge>& edges, const MaskWindow& window,
               std::vector<std::uint8_t>& inside) {
  constexpr std::size_t kRowsAtOnce = 256;
  // The first row or column whose middle lies at or beyond a place, counted from the window's corner.
  const auto first_from = [](double place, std::size_t low, std::size_t high) {
    return static_cast<std::size_t>(
        std::clamp(std::ceil(place - 0.5), static_cast<double>(low), static_cast<double>(high)));
  };
  std::vector<std::vector<double>> crossings(std::min(kRowsAtOnce, window.rows));
  for (std::size_t low = 0; low < window.rows; low += kRowsAtOnce) {
    const std::size_t high = std::min(window.rows, low + kRowsAtOnce);
    for (const RingEdge& edge : edges) {
      const std::size_t end = first_from(std::max(edge.y0, edge.y1) - window.top, low, high);
      for (std::size_t row = first_from(std::min(edge.y0, edge.y1) - window.top, low, high); row < end;
           ++row) {
        const double y = window.top + static_cast<double>(row) + 0.5;
        crossings[row - low].push_back(edge.x0 + (y - edge.y0) / (edge.y1 - edge.y0) * (edge.x1 - edge.x0));
      }
    }
    for (std::size_t row = low; row < high; ++row) {
      std::vector<double>& of_row = crossings[row - low];
      std::sort(of_row.begin(), of_row.end());
      const auto begin = inside.begin() + static_cast<std::ptrdiff_t>(row * window.columns);
      for (std::size_t i = 0; i + 1 < of_row.size(); i += 2) {
        const std::size_t first = first_from(of_row[i] - window.left, 0, window.columns),
                          last = first_from(of_row[i + 1] - window.left, 0, window.columns);
        std::fill(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last),
                  std::uint8_t{1});
      }
      of_row.clear();
    }
  }
}

}  // namespace skyquilt::geo
