#include "core/ground/extend_ground.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace skyquilt::ground {
namespace {

constexpr std::size_t kMaxExtendedNodes =
    16'000'000;  // four times what a flight has that is modelled as a whole

}  // namespace

std::optional<GroundSurface> ExtendGround(const GroundSurface& known, const GroundSurface& added,
                                          const geo::Bounds2& needed) {
  if (known.IsPlane() || needed.IsEmpty()) return known;
  const double cell_m = known.CellSize();
  const Eigen::Vector2d north_east =
      known.SouthWest() + cell_m * Eigen::Vector2d(known.Columns() - 1, known.Rows() - 1);
  // Whole cells on each side, so that the known nodes stay nodes.
  const auto cells = [&](double metres) { return std::max(0, static_cast<int>(std::ceil(metres / cell_m))); };
  const int west = cells(known.SouthWest().x() - needed.min.x());
  const int south = cells(known.SouthWest().y() - needed.min.y());
  const int east = cells(needed.max.x() - north_east.x());
  const int north = cells(needed.max.y() - north_east.y());
  if (west + south + east + north == 0) return known;
  const int columns = known.Columns() + west + east, rows = known.Rows() + south + north;
  const std::size_t nodes = static_cast<std::size_t>(columns) * rows;
  if (nodes > kMaxExtendedNodes) return std::nullopt;
  const Eigen::Vector2d corner = known.SouthWest() - cell_m * Eigen::Vector2d(west, south);
  // A plane says nothing of the ground beyond: there the border goes on.
  const GroundSurface& beyond = added.IsPlane() ? known : added;
  std::vector<float> heights;
  heights.reserve(nodes);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int x = column - west, y = row - south;
      const bool is_known = x >= 0 && y >= 0 && x < known.Columns() && y < known.Rows();
      heights.push_back(
          is_known ? known.Heights()[static_cast<std::size_t>(y) * known.Columns() + x]
                   : static_cast<float>(beyond.HeightAt(corner + cell_m * Eigen::Vector2d(column, row))));
    }
  }
  return GroundSurface::Grid(corner, cell_m, columns, rows, std::move(heights), known.MeanHeight());
}

}  // namespace skyquilt::ground
