#include "core/alignment/scene/relief.h"

#include <algorithm>
#include <cmath>

#include "core/base/bilinear_grid.h"
#include "core/base/median.h"
#include "core/geo/bounds.h"

namespace skyquilt::alignment {
namespace {

constexpr int kMaxCells = 1 << 20;
constexpr int kFewPoints = 50;
constexpr double kFarthestM = 1e6;  // points beyond, or not numbers, are of no use

}  // namespace

Relief Relief::FromPoints(const std::vector<Eigen::Vector3d>& all_points_in_enu, double cell_m,
                          double plane_z_in_enu_m) {
  std::vector<Eigen::Vector3d> points_in_enu;
  for (const Eigen::Vector3d& point : all_points_in_enu) {
    if (point.cwiseAbs().maxCoeff() < kFarthestM) points_in_enu.push_back(point);
  }
  if (points_in_enu.size() < kFewPoints) return Relief(plane_z_in_enu_m);
  std::vector<double> heights;
  geo::Bounds2 bounds;
  for (const Eigen::Vector3d& point : points_in_enu) {
    heights.push_back(point.z());
    bounds.Include(Eigen::Vector2d(point.head<2>()));
  }
  Relief relief(Median(heights));
  cell_m = std::max({cell_m, std::sqrt(bounds.Width() * bounds.Height() / kMaxCells),
                     3.0 * std::max(bounds.Width(), bounds.Height()) / kMaxCells});
  relief.cell_m_ = cell_m;
  relief.south_west_ = bounds.min;
  relief.columns_ = static_cast<int>(bounds.Width() / cell_m) + 2;
  relief.rows_ = static_cast<int>(bounds.Height() / cell_m) + 2;
  const std::size_t cells = static_cast<std::size_t>(relief.columns_) * relief.rows_;
  std::vector<std::vector<double>> inside(cells);
  for (const Eigen::Vector3d& point : points_in_enu) {
    const Eigen::Vector2d at = (point.head<2>() - bounds.min) / cell_m;
    const std::size_t cell = std::lround(at.y()) * relief.columns_ + std::lround(at.x());
    inside[cell].push_back(point.z());
  }
  relief.heights_m_.assign(cells, static_cast<float>(relief.mean_z_m_));
  std::vector<bool> known(cells, false);
  for (std::size_t i = 0; i < cells; ++i) {
    if (inside[i].empty()) continue;
    relief.heights_m_[i] = static_cast<float>(Median(inside[i]));
    known[i] = true;
  }
  // Spread what is known into the empty cells, then let everything settle a little.
  for (int sweep = 0; sweep < 60; ++sweep) {
    for (int row = 0; row < relief.rows_; ++row) {
      for (int column = 0; column < relief.columns_; ++column) {
        const std::size_t at = static_cast<std::size_t>(row) * relief.columns_ + column;
        if (known[at]) continue;
        double sum = 0.0;
        int count = 0;
        const auto add = [&](int r, int c) {
          if (r < 0 || c < 0 || r >= relief.rows_ || c >= relief.columns_) return;
          sum += relief.heights_m_[static_cast<std::size_t>(r) * relief.columns_ + c];
          ++count;
        };
        add(row - 1, column);
        add(row + 1, column);
        add(row, column - 1);
        add(row, column + 1);
        relief.heights_m_[at] = static_cast<float>(sum / count);
      }
    }
  }
  return relief;
}

double Relief::HeightAt(const Eigen::Vector2d& east_north) const {
  if (IsFlat()) return mean_z_m_;
  const Eigen::Vector2d node = (east_north - south_west_) / cell_m_;
  return BilinearAt(heights_m_, columns_, rows_, node.x(), node.y());
}

}  // namespace skyquilt::alignment
