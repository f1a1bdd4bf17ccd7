// GroundSurface: the height of the ground in the flight's enu frame, z = f(E, N). A plane, or a regular grid
// with bilinear interpolation that continues with its border value outside. Immutable; any thread.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace skyquilt::ground {

class GroundSurface {
 public:
  static GroundSurface Plane(double z_in_enu_m);
  // heights_m row by row from the south-west; size columns x rows, at least 2 x 2.
  static GroundSurface Grid(const Eigen::Vector2d& south_west_in_enu, double cell_m, int columns, int rows,
                            std::vector<float> heights_m, double mean_z_in_enu_m);

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

 private:
  double mean_z_m_ = 0.0, min_z_m_ = 0.0, max_z_m_ = 0.0;
  Eigen::Vector2d south_west_ = Eigen::Vector2d::Zero();
  double cell_m_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<float> heights_m_;
};

}  // namespace skyquilt::ground
