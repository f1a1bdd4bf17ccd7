#include "core/alignment/features/sharpness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/alignment/features/picture_detail.h"
#include "core/base/median.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::alignment {
namespace {

constexpr int kSmearDirections = 18;
constexpr std::size_t kMinSharedCells = 12;
constexpr double kTrace = 0.1;
constexpr double kMaxScaleRatio = 1.25;

Eigen::Vector2d MiddleOf(const View& view, int cell) {
  const int column = cell % kDetailCells, row = cell / kDetailCells;
  return {(column + 0.5) / kDetailCells * view.intrinsics.width_px - 0.5,
          (row + 0.5) / kDetailCells * view.intrinsics.height_px - 0.5};
}

int CellAt(const View& view, const Eigen::Vector2d& pixel) {
  const auto number = [](double at_px, int size_px) {
    return std::clamp(static_cast<int>((at_px + 0.5) / size_px * kDetailCells), 0, kDetailCells - 1);
  };
  return number(pixel.y(), view.intrinsics.height_px) * kDetailCells +
         number(pixel.x(), view.intrinsics.width_px);
}

struct SeenPlace {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d step;  // pixels a metre to the east and to the north
};

std::optional<SeenPlace> See(const View& view, const Eigen::Vector3d& place) {
  const auto at = [&](const Eigen::Vector3d& point) {
    return view.intrinsics.Project(view.cam_from_enu * point);
  };
  const double reach_m = view.GsdM();
  const auto pixel = at(place), east = at(place + reach_m * Eigen::Vector3d::UnitX()),
             north = at(place + reach_m * Eigen::Vector3d::UnitY());
  if (!pixel || !east || !north) return std::nullopt;
  SeenPlace seen{*pixel, {}};
  seen.step << (*east - *pixel) / reach_m, (*north - *pixel) / reach_m;
  return seen;
}

// As if the picture were of middle brightness: exposures differ. Where all detail lies in one direction, as
// in crop rows, a trace of it shows in the others, more or less as the rows lie in the pixels.
double DetailOf(const DirectedEnergy& energy, float brightness, const Eigen::Vector2d& along) {
  constexpr double kMiddleGrey = 128.0;
  const double gain = kMiddleGrey / (brightness + 1.0);
  const double mean = (3.0 * energy[0] + energy[2] + 3.0 * energy[4]) / 8.0;  // over all directions
  return gain * gain * (EnergyAlong(energy, along.x(), along.y()) + kTrace * mean + kMinDetail);
}

}  // namespace

std::optional<double> SharpnessAgainst(const PictureDetail& own, const View& own_view,
                                       const PictureDetail& other, const View& other_view,
                                       const Relief& relief) {
  if (own.cells.empty() || other.cells.empty()) return std::nullopt;
  std::array<std::vector<double>, 2 * kSmearDirections> shares;  // of fine detail, then of coarse
  for (std::size_t k = 0; k < own.cells.size(); ++k) {
    Eigen::Vector3d place;
    if (!MeetGround(own_view, relief, MiddleOf(own_view, static_cast<int>(k)), &place)) continue;
    const std::optional<SeenPlace> in_own = See(own_view, place), in_other = See(other_view, place);
    if (!in_own || !in_other || !other_view.intrinsics.IsInImage(in_other->pixel)) continue;
    const DetailCell& own_cell = own.cells[k];
    const DetailCell& other_cell = other.cells[CellAt(other_view, in_other->pixel)];
    for (int d = 0; d < kSmearDirections; ++d) {
      const Eigen::Vector2d along(std::cos(geo::kPi * d / kSmearDirections),
                                  std::sin(geo::kPi * d / kSmearDirections));
      const Eigen::Vector2d own_step = in_own->step * along, other_step = in_other->step * along;
      const double ratio = (own_step.norm() / own_view.intrinsics.width_px) /
                           (other_step.norm() / other_view.intrinsics.width_px);
      if (ratio > kMaxScaleRatio || ratio < 1.0 / kMaxScaleRatio) continue;
      const auto compare = [&](const DirectedEnergy& own_energy, const DirectedEnergy& other_energy) {
        return DetailOf(own_energy, own_cell.brightness, own_step.normalized()) /
               DetailOf(other_energy, other_cell.brightness, other_step.normalized());
      };
      shares[d].push_back(compare(own_cell.fine, other_cell.fine));
      shares[kSmearDirections + d].push_back(compare(own_cell.coarse, other_cell.coarse));
    }
  }
  double least = std::numeric_limits<double>::max();
  for (std::vector<double>& of_direction : shares) {
    if (of_direction.size() < kMinSharedCells) return std::nullopt;
    least = std::min(least, Median(std::move(of_direction)));
  }
  return least;
}

}  // namespace skyquilt::alignment
