#include "core/ground/ground_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/bilinear_grid.h"
#include "core/base/check.h"

namespace skyquilt::ground {

GroundSurface GroundSurface::Plane(double z_in_enu_m) {
  GroundSurface surface;
  surface.mean_z_m_ = surface.min_z_m_ = surface.max_z_m_ = z_in_enu_m;
  return surface;
}

GroundSurface GroundSurface::Grid(const Eigen::Vector2d& south_west_in_enu, double cell_m, int columns,
                                  int rows, std::vector<float> heights_m, double mean_z_in_enu_m) {
  SKYQUILT_CHECK(columns >= 2 && rows >= 2 && cell_m > 0.0, "a ground grid needs at least 2 x 2 cells");
  SKYQUILT_CHECK(heights_m.size() == static_cast<std::size_t>(columns) * rows,
                 "ground grid size and data differ");
  GroundSurface surface;
  const auto [low, high] = std::minmax_element(heights_m.begin(), heights_m.end());
  surface.min_z_m_ = *low;
  surface.max_z_m_ = *high;
  surface.mean_z_m_ = mean_z_in_enu_m;
  surface.south_west_ = south_west_in_enu;
  surface.cell_m_ = cell_m;
  surface.columns_ = columns;
  surface.rows_ = rows;
  surface.heights_m_ = std::move(heights_m);
  return surface;
}

GroundSurface GroundSurface::WithSteps(const Eigen::Vector2d& south_west_in_enu, double cell_m, int columns,
                                       int rows, std::vector<float> heights_m, double mean_z_in_enu_m) {
  GroundSurface surface =
      Grid(south_west_in_enu, cell_m, columns, rows, std::move(heights_m), mean_z_in_enu_m);
  for (std::size_t size = 0; size < kTopCells.size(); ++size) {
    const int cells = kTopCells[size], across = (columns + cells - 1) / cells,
              up = (rows + cells - 1) / cells;
    surface.tops_m_[size].assign(static_cast<std::size_t>(across) * up, static_cast<float>(surface.min_z_m_));
    for (int row = 0; row < rows; ++row) {
      const float* height = surface.heights_m_.data() + static_cast<std::size_t>(row) * columns;
      float* tops = surface.tops_m_[size].data() + static_cast<std::size_t>(row / cells) * across;
      for (int column = 0; column < columns; ++column) {
        float& top = tops[column / cells];
        top = std::max(top, height[column]);
      }
    }
  }
  return surface;
}

double GroundSurface::HeightAt(const Eigen::Vector2d& east_north) const {
  if (IsPlane()) return mean_z_m_;
  const Eigen::Vector2d node = (east_north - south_west_) / cell_m_;
  return BilinearAt(heights_m_, columns_, rows_, node.x(), node.y());
}

namespace {

constexpr double kOwnCells = 2.0;  // a point's surroundings, in which its own height is not sure
constexpr double kToleranceCells = 1.0;

// How far along a line with this step the edge lies of the square of cells, a power of two, that `cell` is
// in. Places on the grid are not negative: whole numbers are had by cutting off, which is quicker than
// std::floor.
double ToEdge(double at, int cell, double step, int square_bits) {
  if (std::abs(step) < 1e-12) return std::numeric_limits<double>::infinity();
  const int square = cell >> square_bits;
  return (static_cast<double>((step > 0.0 ? square + 1 : square) << square_bits) - at) / step;
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
  struct Squares {
    const float* tops;
    int across, bits;
  };
  std::array<Squares, GroundSurface::kTopCells.size()> sizes;
  for (std::size_t size = 0; size < sizes.size(); ++size) {
    const int cells = GroundSurface::kTopCells[size];
    sizes[size] = {surface.Tops(size).data(), (columns + cells - 1) / cells,
                   std::countr_zero(static_cast<unsigned>(cells))};
  }
  for (double t = kOwnCells; t < end;) {
    const double x = start.x() + t * step.x(), y = start.y() + t * step.y();
    if (!(x >= 0.0 && y >= 0.0 && x < columns && y < rows)) return false;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const double line_m = base_m + t * rise_m;
    double passed = 0.0;  // over the square of which nothing is as high, if one is
    for (const Squares& size : sizes) {
      const std::ptrdiff_t square =
          static_cast<std::ptrdiff_t>(row >> size.bits) * size.across + (column >> size.bits);
      if (size.tops[square] > line_m) continue;
      passed = std::min(ToEdge(x, column, step.x(), size.bits), ToEdge(y, row, step.y(), size.bits));
      if (passed > 0.0) break;
    }
    if (passed > 0.0) {
      t = kOwnCells + std::max(t - kOwnCells + 1.0, std::ceil(t - kOwnCells + passed));  // on whole cells
      continue;
    }
    if (heights[static_cast<std::ptrdiff_t>(row) * columns + column] > line_m) return true;
    t += 1.0;
  }
  return false;
}

}  // namespace skyquilt::ground
