#include "core/ground/occlusion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace skyquilt::ground {
namespace {

constexpr double kOwnCells = 2.0;  // a point's surroundings, in which its own height is not sure
constexpr double kToleranceCells = 1.0;

// How far along a line with this step a square's edge lies.
double ToEdge(double at, double step, int square) {
  if (std::abs(step) < 1e-12) return std::numeric_limits<double>::infinity();
  const double first = std::floor(at / square) * square;
  return ((step > 0.0 ? first + square : first) - at) / step;
}

}  // namespace

bool IsOccluded(const GroundSurface& surface, const Eigen::Vector3d& point_in_enu,
                const Eigen::Vector3d& eye_in_enu) {
  if (!surface.HasSteps()) return false;
  const double cell_m = surface.CellSize();
  const Eigen::Vector2d away = eye_in_enu.head<2>() - point_in_enu.head<2>();
  const double away_cells = away.norm() / cell_m;
  if (!(away_cells > kOwnCells)) return false;
  const Eigen::Vector2d step = away / (away_cells * cell_m);  // cells a cell
  const double rise_m = (eye_in_enu.z() - point_in_enu.z()) / away_cells;
  if (!(rise_m > 0.0)) return false;
  // Cells count from their corners here: the centre of the first lies at a half.
  const Eigen::Vector2d start =
      (point_in_enu.head<2>() - surface.SouthWest()) / cell_m + Eigen::Vector2d::Constant(0.5);
  const double base_m = point_in_enu.z() + kToleranceCells * cell_m;
  const double end = std::min(away_cells, (surface.MaxHeight() - base_m) / rise_m);
  const int columns = surface.Columns(), rows = surface.Rows();
  const float* heights = surface.Heights().data();
  constexpr auto& kSquares = GroundSurface::kTopCells;
  for (double t = kOwnCells; t < end;) {
    const Eigen::Vector2d at = start + t * step;
    const int column = static_cast<int>(std::floor(at.x())), row = static_cast<int>(std::floor(at.y()));
    if (column < 0 || row < 0 || column >= columns || row >= rows) return false;
    const double line_m = base_m + t * rise_m;
    double passed = 0.0;  // over the square of which nothing is as high, if one is
    for (std::size_t size = 0; size < kSquares.size() && passed == 0.0; ++size) {
      const int cells = kSquares[size], across = (columns + cells - 1) / cells;
      if (surface.Tops(size)[static_cast<std::size_t>(row / cells) * across + column / cells] <= line_m)
        passed = std::min(ToEdge(at.x(), step.x(), cells), ToEdge(at.y(), step.y(), cells));
    }
    if (passed > 0.0) {
      t = kOwnCells + std::max(t - kOwnCells + 1.0, std::ceil(t - kOwnCells + passed));  // on whole cells
      continue;
    }
    if (heights[static_cast<std::size_t>(row) * columns + column] > line_m) return true;
    t += 1.0;
  }
  return false;
}

}  // namespace skyquilt::ground
