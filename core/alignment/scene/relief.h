// Relief: the coarse shape of the ground as the alignment itself knows it, so that a rematch searches in
// the right place. A plane until points are known. Values; any thread. (The map's own surface is
// core/ground's.)
#pragma once

#include <Eigen/Core>
#include <vector>

namespace skyquilt::alignment {

class Relief {
 public:
  explicit Relief(double plane_z_in_enu_m) : mean_z_m_(plane_z_in_enu_m) {}
  // Medians of the points' heights in cells of cell_m, empty cells filled from their neighbours.
  static Relief FromPoints(const std::vector<Eigen::Vector3d>& all_points_in_enu, double cell_m,
                           double plane_z_in_enu_m);

  bool IsFlat() const { return heights_m_.empty(); }
  double MeanHeight() const { return mean_z_m_; }
  double HeightAt(const Eigen::Vector2d& east_north) const;

 private:
  double mean_z_m_ = 0.0;
  Eigen::Vector2d south_west_ = Eigen::Vector2d::Zero();
  double cell_m_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<float> heights_m_;
};

}  // namespace skyquilt::alignment
