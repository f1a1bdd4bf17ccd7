#include "core/ground/ground_surface.h"

#include <algorithm>
#include <cmath>
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

}  // namespace skyquilt::ground
