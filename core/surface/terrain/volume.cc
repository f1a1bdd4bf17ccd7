#include "core/surface/terrain/volume.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skyquilt::surface {
namespace {

// height = at_origin + slope . place
struct BasePlane {
  double at_origin_m = 0.0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  // metres a cell
  double sigma_m = 0.0;                             // of all of it together

  double At(double x, double y) const { return at_origin_m + slope.x() * x + slope.y() * y; }
};

BasePlane PlaneThrough(const std::vector<EdgeHeight>& edge) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const auto as_point = [](const EdgeHeight& at) {
    return Eigen::Vector3d(at.place_in_cells.x(), at.place_in_cells.y(), at.height_m);
  };
  for (const EdgeHeight& at : edge) mean += as_point(at) / static_cast<double>(edge.size());
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const EdgeHeight& at : edge) {
    const Eigen::Vector3d d = as_point(at) - mean;
    normal += d.head<2>() * d.head<2>().transpose();
    right += d.head<2>() * d.z();
  }
  BasePlane plane;
  const double determinant = normal(0, 0) * normal(1, 1) - normal(0, 1) * normal(1, 0);
  // An edge along one line has no slope across it.
  if (determinant > 1e-9 * normal.trace() * normal.trace()) {
    plane.slope = {(normal(1, 1) * right.x() - normal(0, 1) * right.y()) / determinant,
                   (normal(0, 0) * right.y() - normal(1, 0) * right.x()) / determinant};
  }
  plane.at_origin_m = mean.z() - plane.slope.dot(mean.head<2>());
  return plane;
}

// How unsure a plane is that was taken from the edge.
double SigmaOf(const BasePlane& plane, const std::vector<EdgeHeight>& edge, double cell_m) {
  double squares = 0.0, length_m = 0.0;
  for (std::size_t i = 0; i < edge.size(); ++i) {
    const Eigen::Vector2d& place = edge[i].place_in_cells;
    squares += std::pow(edge[i].height_m - plane.At(place.x(), place.y()), 2);
    length_m += cell_m * (place - edge[(i + 1) % edge.size()].place_in_cells).norm();
  }
  const double told = std::max(1.0, length_m / kCorrelatedM);
  return std::sqrt(squares / static_cast<double>(edge.size()) / told);
}

BasePlane BaseOf(const std::vector<EdgeHeight>& edge, VolumeBase base, double given_m, double cell_m) {
  if (base == VolumeBase::kGiven) return {.at_origin_m = given_m};
  BasePlane fitted = PlaneThrough(edge);
  fitted.sigma_m = SigmaOf(fitted, edge, cell_m);
  if (base == VolumeBase::kPlane) return fitted;
  const auto lowest =
      std::min_element(edge.begin(), edge.end(),
                       [](const EdgeHeight& a, const EdgeHeight& b) { return a.height_m < b.height_m; });
  return {.at_origin_m = lowest->height_m, .sigma_m = fitted.sigma_m};
}

// What was summed up over the cells, and what their errors follow from.
struct Sums {
  AreaVolume volume;
  std::int64_t known = 0, measured = 0;
  double squares = 0.0;  // of the heights above the base
  double rises = 0.0;    // from cell to cell, by the cell, of all surfaces whose steps may stand aside
};

// `base_at` gives the base of a cell by its column, row and place in the grid, `is_measured` and `rise_at`
// theirs by its place. Cells without height or base are passed over.
template <typename BaseAt, typename IsMeasured, typename RiseAtCell>
Sums SumOver(const AreaHeights& area, const BaseAt& base_at, const IsMeasured& is_measured,
             const RiseAtCell& rise_at) {
  const double cell_m2 = area.cell_m * area.cell_m;
  Sums sums;
  AreaVolume& volume = sums.volume;
  volume.lowest_m = std::numeric_limits<double>::infinity();
  volume.highest_m = -volume.lowest_m;
  double heights = 0.0, bases = 0.0;
  for (int row = 0; row < area.rows; ++row) {
    for (int column = 0; column < area.columns; ++column) {
      const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(area.columns) +
                             static_cast<std::size_t>(column);
      if (area.is_inside[at] == 0) continue;
      const double height_m = area.heights_m[at], base_m = base_at(column, row, at);
      const double above_m = height_m - base_m;
      if (!std::isfinite(above_m)) continue;
      ++sums.known;
      sums.measured += is_measured(at) ? 1 : 0;
      (above_m > 0.0 ? volume.cut_m3 : volume.fill_m3) += std::abs(above_m) * cell_m2;
      volume.lowest_m = std::min(volume.lowest_m, height_m);
      volume.highest_m = std::max(volume.highest_m, height_m);
      heights += height_m;
      sums.squares += above_m * above_m;
      bases += base_m;
      sums.rises += rise_at(at);
    }
  }
  const auto count = static_cast<double>(sums.known);
  volume.base_m = bases / count;
  volume.mean_m = heights / count;
  volume.area_m2 = count * cell_m2;
  volume.measured_share = static_cast<double>(sums.measured) / count;
  return sums;
}

// `base_sigma_m`: of the whole base together; absent: nobody knows.
std::optional<AreaVolume> WithSigma(const Sums& sums, double cell_m, std::optional<double> base_sigma_m) {
  if (sums.known == 0) return std::nullopt;
  AreaVolume volume = sums.volume;
  if (volume.measured_share < kMinMeasuredShare || !base_sigma_m) return volume;
  const double cell_m2 = cell_m * cell_m, mean_above_m = volume.mean_m - volume.base_m;
  const double spread_m =
      std::sqrt(std::max(0.0, sums.squares / static_cast<double>(sums.known) - mean_above_m * mean_above_m));
  const double steps_m3 = kStepsOffCells * sums.rises * cell_m2;  // rises by the cell, half a cell aside
  const double base_m3 = *base_sigma_m * volume.area_m2;
  const double unmeasured_m2 = static_cast<double>(sums.known - sums.measured) * cell_m2;
  const double patches = std::max(1.0, unmeasured_m2 / (kCorrelatedM * kCorrelatedM));
  const double filled_m3 = spread_m * unmeasured_m2 / std::sqrt(patches);
  volume.net_sigma_m3 = std::sqrt(steps_m3 * steps_m3 + base_m3 * base_m3 + filled_m3 * filled_m3);
  return volume;
}

}  // namespace

double RiseAt(std::span<const float> heights_m, int columns, std::size_t cell) {
  const auto across = static_cast<std::size_t>(columns);
  const auto step_to = [&](bool is_there, std::size_t next) {
    const double step_m = is_there ? heights_m[next] - heights_m[cell] : 0.0;
    return std::isfinite(step_m) ? step_m : 0.0;
  };
  return std::hypot(step_to((cell + 1) % across != 0, cell + 1),
                    step_to(cell + across < heights_m.size(), cell + across));
}

std::optional<AreaVolume> VolumeOver(const AreaHeights& area, const std::vector<EdgeHeight>& edge,
                                     VolumeBase base, double given_m) {
  if (edge.empty() && base != VolumeBase::kGiven) return std::nullopt;
  const BasePlane plane = BaseOf(edge, base, given_m, area.cell_m);
  const Sums sums = SumOver(
      area, [&](int column, int row, std::size_t) { return plane.At(column + 0.5, row + 0.5); },
      [&](std::size_t at) { return area.is_measured[at] != 0; },
      [&](std::size_t at) { return RiseAt(area.heights_m, area.columns, at); });
  // A height that is given counts from a zero of its own: how far off the map's that is, no edge tells.
  return WithSigma(sums, area.cell_m,
                   base == VolumeBase::kGiven ? std::nullopt : std::optional<double>(plane.sigma_m));
}

std::optional<AreaVolume> VolumeSince(const AreaHeights& area, const EarlierHeights& earlier) {
  const double larger = std::max(1.0, earlier.own_cell_m / area.cell_m);
  const Sums sums = SumOver(
      area, [&](int, int, std::size_t at) { return static_cast<double>(earlier.heights_m[at]); },
      [&](std::size_t at) { return area.is_measured[at] != 0 && earlier.is_measured[at] != 0; },
      // Each flight's steps stand aside by themselves, by its own cells.
      [&](std::size_t at) {
        return std::hypot(RiseAt(area.heights_m, area.columns, at),
                          larger * RiseAt(earlier.heights_m, area.columns, at));
      });
  return WithSigma(sums, area.cell_m, earlier.sigma_m);
}

}  // namespace skyquilt::surface
