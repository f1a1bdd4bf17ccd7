// GroundSurface: the height of the ground in the flight's enu frame, z = f(E, N). A plane, or a regular grid
// with bilinear interpolation that continues with its border value outside. With what stands on the ground it
// steps at walls, and hides what lies behind (IsOccluded). Immutable; any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace skyquilt::ground {

class GroundSurface {
 public:
  static GroundSurface Plane(double z_in_enu_m);
  // heights_m row by row from the south-west; size columns x rows, at least 2 x 2.
  static GroundSurface Grid(const Eigen::Vector2d& south_west_in_enu, double cell_m, int columns, int rows,
                            std::vector<float> heights_m, double mean_z_in_enu_m);

  // As Grid, of fine cells with roofs and crowns.
  static GroundSurface WithSteps(const Eigen::Vector2d& south_west_in_enu, double cell_m, int columns,
                                 int rows, std::vector<float> heights_m, double mean_z_in_enu_m);

  double HeightAt(const Eigen::Vector2d& east_north) const;
  bool IsPlane() const { return heights_m_.empty(); }
  double MeanHeight() const { return mean_z_m_; }
  double MinHeight() const { return min_z_m_; }
  double MaxHeight() const { return max_z_m_; }
  double CellSize() const { return cell_m_; }
  // Of a grid, as given to Grid.
  const Eigen::Vector2d& SouthWest() const { return south_west_; }
  int Columns() const { return columns_; }
  int Rows() const { return rows_; }
  const std::vector<float>& Heights() const { return heights_m_; }
  bool HasSteps() const { return !tops_m_.front().empty(); }
  // Where it has steps: the highest of each square of so many cells a side (powers of two), row by row.
  static constexpr std::array<int, 3> kTopCells = {64, 16, 4};
  const std::vector<float>& Tops(std::size_t size) const { return tops_m_[size]; }

 private:
  double mean_z_m_ = 0.0, min_z_m_ = 0.0, max_z_m_ = 0.0;
  Eigen::Vector2d south_west_ = Eigen::Vector2d::Zero();
  double cell_m_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<float> heights_m_;
  std::array<std::vector<float>, kTopCells.size()> tops_m_;
};

// IsOccluded: whether something stands between a point of a stepped ground surface and whoever looks at it:
// walks the line over the cells, squares of cells at a time where nothing there is as high. Things less than
// a cell high over the line, and the point's own surroundings, do not hide. Points in enu, metres; the eye
// lies above the surface. Pure; any thread.
bool IsOccluded(const GroundSurface& surface, const Eigen::Vector3d& point_in_enu,
                const Eigen::Vector3d& eye_in_enu);

}  // namespace skyquilt::ground
