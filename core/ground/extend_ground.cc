#include "core/ground/extend_ground.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/geo/boundary.h"

namespace skyquilt::ground {
namespace {

using Outline = std::vector<Eigen::Vector2d>;

constexpr std::size_t kMaxExtendedNodes =
    16'000'000;  // four times what a flight has that is modelled as a whole

struct Nodes {
  Eigen::Vector2d south_west_in_enu = Eigen::Vector2d::Zero();
  double cell_m = 1.0;
  int columns = 0, rows = 0;

  std::size_t Count() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  Eigen::Vector2d At(int column, int row) const {
    return south_west_in_enu + cell_m * Eigen::Vector2d(column, row);
  }
};

// Those of a plane reach a cell further than is needed: there it goes on.
Nodes NodesOf(const GroundSurface& known, const GroundSurface& added, const geo::Bounds2& needed) {
  if (!known.IsPlane()) return {known.SouthWest(), known.CellSize(), known.Columns(), known.Rows()};
  const double cell_m = added.CellSize();
  const auto count = [&](double metres) { return static_cast<int>(std::ceil(metres / cell_m)) + 3; };
  return {needed.min - Eigen::Vector2d::Constant(cell_m), cell_m, count(needed.Width()),
          count(needed.Height())};
}

// 1 for nodes within outlines, and for those beside them: heights lie between nodes.
std::vector<std::uint8_t> NodesWithin(const std::vector<Outline>& outlines, const Nodes& nodes) {
  const auto columns = static_cast<std::size_t>(nodes.columns), rows = static_cast<std::size_t>(nodes.rows);
  std::vector<std::uint8_t> within(nodes.Count(), 0);
  for (const Outline& outline : outlines) {
    std::vector<geo::RingEdge> edges;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const auto in_cells = [&](const Eigen::Vector2d& place) -> Eigen::Vector2d {
        return (place - nodes.south_west_in_enu) / nodes.cell_m + Eigen::Vector2d::Constant(0.5);
      };
      const Eigen::Vector2d from = in_cells(outline[i]), to = in_cells(outline[(i + 1) % outline.size()]);
      edges.push_back({from.x(), from.y(), to.x(), to.y()});
    }
    geo::MaskRings(edges, {0.0, 0.0, columns, rows}, within);
  }
  std::vector<std::uint8_t> with_those_beside = within;
  for (std::size_t node = 0; node < within.size(); ++node) {
    if (within[node] == 0) continue;
    const std::size_t row = node / columns, column = node % columns;
    for (std::size_t r = row - std::min<std::size_t>(row, 1); r <= std::min(row + 1, rows - 1); ++r) {
      for (std::size_t c = column - std::min<std::size_t>(column, 1); c <= std::min(column + 1, columns - 1);
           ++c)
        with_those_beside[r * columns + c] = 1;
    }
  }
  return with_those_beside;
}

}  // namespace

std::optional<GroundSurface> ExtendGround(const GroundSurface& known, const GroundSurface& added,
                                          const geo::Bounds2& needed, const std::vector<Outline>& shown) {
  if (needed.IsEmpty() || (known.IsPlane() && added.IsPlane())) return known;
  const Nodes own = NodesOf(known, added, needed);
  const Eigen::Vector2d south_west = own.south_west_in_enu,
                        north_east = own.At(own.columns - 1, own.rows - 1);
  // Whole cells on each side, so that the known nodes stay nodes.
  const auto cells = [&](double metres) {
    return std::max(0, static_cast<int>(std::ceil(metres / own.cell_m)));
  };
  const int west = cells(south_west.x() - needed.min.x()), south = cells(south_west.y() - needed.min.y());
  const int east = cells(needed.max.x() - north_east.x()), north = cells(needed.max.y() - north_east.y());
  bool is_as_known = west + south + east + north == 0;
  if (is_as_known && added.IsPlane()) return known;
  const Nodes nodes{own.At(-west, -south), own.cell_m, own.columns + west + east, own.rows + south + north};
  if (nodes.Count() > kMaxExtendedNodes) return std::nullopt;
  // A plane says nothing of the ground beyond: there the border goes on.
  const GroundSurface& beyond = added.IsPlane() ? known : added;
  const std::vector<std::uint8_t> is_shown = NodesWithin(shown, nodes);
  std::vector<float> heights;
  heights.reserve(nodes.Count());
  for (int row = 0; row < nodes.rows; ++row) {
    for (int column = 0; column < nodes.columns; ++column) {
      const int x = column - west, y = row - south;
      const Eigen::Vector2d place = nodes.At(column, row);
      const bool is_known = x >= 0 && y >= 0 && x < own.columns && y < own.rows;
      const bool stays =
          is_known && (added.IsPlane() || is_shown[heights.size()] != 0 || !needed.Contains(place));
      is_as_known = is_as_known && stays;
      if (!stays)
        heights.push_back(static_cast<float>(beyond.HeightAt(place)));
      else if (known.IsPlane())
        heights.push_back(static_cast<float>(known.MeanHeight()));
      else
        heights.push_back(known.Heights()[static_cast<std::size_t>(y) * known.Columns() + x]);
    }
  }
  if (is_as_known) return known;
  return GroundSurface::Grid(nodes.south_west_in_enu, nodes.cell_m, nodes.columns, nodes.rows,
                             std::move(heights), known.MeanHeight());
}

}  // namespace skyquilt::ground
