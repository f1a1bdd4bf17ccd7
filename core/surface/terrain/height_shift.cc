#include "core/surface/terrain/height_shift.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/base/median.h"

namespace skyquilt::surface {
namespace {

// So many cells tell how well a shift fits.
constexpr std::size_t kSampledCells = 10'000;
// Noise fits by chance here or there, a percent or two better than elsewhere; hills, heaps and walls by a
// quarter and more. Places closer than this are no others.
constexpr double kClearly = 0.95, kElsewhereM = 2.5;
// Of level ground: patches as large as heaps, of which half is known.
constexpr double kPatchM = 8.0;
constexpr int kMinPatchCells = 4, kMaxPatchCells = 64;
constexpr std::size_t kMinPatches = 8;
constexpr int kLevelRounds = 3;

// Between the four cells around a place, NaN unless all of them are known.
double Between(const HeightGrid& grid, double column, double row) {
  const double left = std::floor(column), top = std::floor(row);
  if (!(left >= 0 && top >= 0 && left + 1 < grid.columns && top + 1 < grid.rows)) return std::nan("");
  const auto across = static_cast<std::size_t>(grid.columns);
  const float* const at =
      grid.heights_m.data() + static_cast<std::size_t>(top) * across + static_cast<std::size_t>(left);
  const double u = column - left, v = row - top;
  return (1 - v) * ((1 - u) * at[0] + u * at[1]) + v * ((1 - u) * at[across] + u * at[across + 1]);
}

// The median of what is not far from it: what changed, up or down, draws it no more.
double LevelOf(const std::vector<double>& differences_m) {
  double level_m = Median(differences_m);
  for (int round = 0; round < kLevelRounds; ++round) {
    std::vector<double> near_m;
    for (const double difference_m : differences_m) {
      if (std::abs(difference_m - level_m) < kChangedM) near_m.push_back(difference_m);
    }
    level_m = MedianIfAny(std::move(near_m)).value_or(level_m);
  }
  return level_m;
}

// Compares at some of the cells that both know, with `then` so many cells west and north of it.
class Comparison {
 public:
  Comparison(const HeightGrid& now, const HeightGrid& then) : now_(now), then_(then) {
    for (std::size_t i = 0; i < now.heights_m.size(); ++i) {
      if (std::isfinite(now.heights_m[i]) && std::isfinite(then.heights_m[i])) sampled_.push_back(i);
    }
    // An odd stride meets rows of trees and panels at every phase.
    const std::size_t stride = (sampled_.size() / kSampledCells) | 1;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < sampled_.size(); i += stride) sampled_[kept++] = sampled_[i];
    sampled_.resize(kept);
  }

  // now less then, of the cells that both know.
  std::vector<double> Differences(const Eigen::Vector2d& shift_cells) const {
    std::vector<double> differences_m;
    const auto across = static_cast<std::size_t>(now_.columns);
    for (const std::size_t i : sampled_) {
      const std::size_t row = i / across, column = i % across;
      const double before_m = Between(then_, static_cast<double>(column) - shift_cells.x(),
                                      static_cast<double>(row) - shift_cells.y());
      if (std::isfinite(before_m)) differences_m.push_back(now_.heights_m[i] - before_m);
    }
    return differences_m;
  }
  // The mean of what differs from the median, changes cut off; as large as it can be where too few know.
  double Misfit(const Eigen::Vector2d& shift_cells) const {
    const std::vector<double> differences_m = Differences(shift_cells);
    if (differences_m.size() < kMinComparedCells) return kChangedM;
    const double median_m = Median(differences_m);
    double sum = 0.0;
    for (const double difference_m : differences_m)
      sum += std::min(std::abs(difference_m - median_m), kChangedM);
    return sum / static_cast<double>(differences_m.size());
  }

 private:
  const HeightGrid &now_, &then_;
  std::vector<std::size_t> sampled_;
};

// The place of a parabola's least value through three misfits a cell apart, between -0.5 and 0.5.
double LeastBetween(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend > 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

struct Tried {
  Eigen::Vector2d cells = Eigen::Vector2d::Zero();
  double misfit = 0.0;
};

// In cells, rows count to the south. All are whole cells, so that none gains by what lies between them.
std::variant<std::optional<Eigen::Vector2d>, ShiftFault> Sideways(const Comparison& comparison,
                                                                  double cell_m) {
  const int most = static_cast<int>(std::ceil(kMaxSidewaysM / cell_m)) + 1;
  std::vector<Tried> tried;
  for (int y = -most; y <= most; ++y) {
    for (int x = -most; x <= most; ++x) tried.push_back({{x, y}, comparison.Misfit({x, y})});
  }
  const Tried best = *std::min_element(tried.begin(), tried.end(),
                                       [](const Tried& a, const Tried& b) { return a.misfit < b.misfit; });
  const double elsewhere_cells = std::max(2.0, kElsewhereM / cell_m);
  double elsewhere = kChangedM;
  for (const Tried& other : tried) {
    if ((other.cells - best.cells).norm() > elsewhere_cells) elsewhere = std::min(elsewhere, other.misfit);
  }
  if (best.misfit >= kClearly * elsewhere) return std::nullopt;
  if (best.cells.cwiseAbs().maxCoeff() >= most || cell_m * best.cells.norm() > kMaxSidewaysM + cell_m)
    return ShiftFault::kTooFar;
  const auto beside = [&](double x, double y) {
    return comparison.Misfit(best.cells + Eigen::Vector2d(x, y));
  };
  const Eigen::Vector2d between(LeastBetween(beside(-1, 0), best.misfit, beside(1, 0)),
                                LeastBetween(beside(0, -1), best.misfit, beside(0, 1)));
  return std::optional<Eigen::Vector2d>(best.cells + between);
}

// How much the levels of patches scatter, those of changes left out by the median of what they are off.
std::optional<double> SpreadOfPatches(const HeightGrid& now, const HeightGrid& then,
                                      const Eigen::Vector2d& shift_cells, double up_m) {
  const int side =
      std::clamp(static_cast<int>(std::lround(kPatchM / now.cell_m)), kMinPatchCells, kMaxPatchCells);
  std::vector<double> off_m, patch_m;
  for (int top = 0; top < now.rows; top += side) {
    for (int left = 0; left < now.columns; left += side) {
      patch_m.clear();
      for (int row = top; row < std::min(now.rows, top + side); ++row) {
        for (int column = left; column < std::min(now.columns, left + side); ++column) {
          const auto cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(now.columns) +
                            static_cast<std::size_t>(column);
          const double difference_m =
              now.heights_m[cell] - Between(then, column - shift_cells.x(), row - shift_cells.y());
          if (std::isfinite(difference_m)) patch_m.push_back(difference_m);
        }
      }
      if (2 * patch_m.size() >= static_cast<std::size_t>(side) * static_cast<std::size_t>(side))
        off_m.push_back(std::abs(Median(patch_m) - up_m));
    }
  }
  if (off_m.size() < kMinPatches) return std::nullopt;
  return kSigmaOfMedian * Median(std::move(off_m));
}

}  // namespace

std::variant<HeightShift, ShiftFault> ShiftBetween(const HeightGrid& now, const HeightGrid& then) {
  const Comparison comparison(now, then);
  if (comparison.Differences(Eigen::Vector2d::Zero()).size() < kMinComparedCells)
    return ShiftFault::kTooLittle;
  const auto sideways = Sideways(comparison, now.cell_m);
  if (const auto* const fault = std::get_if<ShiftFault>(&sideways)) return *fault;
  const auto& found = std::get<std::optional<Eigen::Vector2d>>(sideways);
  const Eigen::Vector2d cells = found.value_or(Eigen::Vector2d::Zero());
  const std::vector<double> differences_m = comparison.Differences(cells);
  if (differences_m.size() < kMinComparedCells) return ShiftFault::kTooLittle;
  HeightShift shift;
  if (found) shift.east_north_m = now.cell_m * Eigen::Vector2d(cells.x(), -cells.y());
  shift.up_m = LevelOf(differences_m);
  const auto alike = std::count_if(differences_m.begin(), differences_m.end(), [&](double difference_m) {
    return std::abs(difference_m - shift.up_m) < kChangedM;
  });
  shift.alike_share = static_cast<double>(alike) / static_cast<double>(differences_m.size());
  shift.sigma_m = SpreadOfPatches(now, then, cells, shift.up_m);
  if (!shift.sigma_m) return ShiftFault::kTooLittle;
  return shift;
}

}  // namespace skyquilt::surface
