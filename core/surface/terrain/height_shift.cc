#include "core/surface/terrain/height_shift.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace skyquilt::surface {
namespace {

// So many cells tell how well a shift fits.
constexpr std::size_t kSampledCells = 10'000;
// A difference beyond this is one that changed, however large it is.
constexpr double kChangedM = 0.5;
// Of what differs without a shift sideways, so much must be gone with it.
constexpr double kMinGain = 0.05;
constexpr int kPatchCells = 16, kMinPatches = 8;
constexpr double kSigmaOfMad = 1.4826;

double MedianOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

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

// Compares at every so-manieth cell of `now`, with `then` so many cells west and north of it.
class Comparison {
 public:
  Comparison(const HeightGrid& now, const HeightGrid& then) : now_(now), then_(then) {
    std::size_t known = 0;
    for (const float height_m : now.heights_m) known += std::isfinite(height_m) ? 1 : 0;
    const std::size_t every = std::max<std::size_t>(1, known / kSampledCells);
    std::size_t met = 0;
    for (std::size_t i = 0; i < now.heights_m.size(); ++i) {
      if (std::isfinite(now.heights_m[i]) && met++ % every == 0) sampled_.push_back(i);
    }
  }

  // now less then; the cells that both know.
  const std::vector<double>& Differences(const Eigen::Vector2d& shift_cells) {
    differences_.clear();
    for (const std::size_t i : sampled_) {
      const auto across = static_cast<std::size_t>(now_.columns);
      const double column = static_cast<double>(i % across) - shift_cells.x(),
                   row = static_cast<double>(i / across) - shift_cells.y();
      const double before_m = Between(then_, column, row);
      if (std::isfinite(before_m)) differences_.push_back(now_.heights_m[i] - before_m);
    }
    return differences_;
  }
  // The mean of what differs from the median, changes cut off; absent: too few know.
  std::optional<double> Misfit(const Eigen::Vector2d& shift_cells) {
    Differences(shift_cells);
    if (differences_.size() < kMinComparedCells) return std::nullopt;
    const double median_m = MedianOf(differences_);
    double sum = 0.0;
    for (const double difference_m : differences_)
      sum += std::min(std::abs(difference_m - median_m), kChangedM);
    return sum / static_cast<double>(differences_.size());
  }

 private:
  const HeightGrid &now_, &then_;
  std::vector<std::size_t> sampled_;
  std::vector<double> differences_;
};

// The place of a parabola's least value through three misfits a cell apart, between -0.5 and 0.5.
double LeastBetween(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend > 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

// In cells, rows count to the south. Absent: level ground, or the best lies beyond what is tried.
std::optional<Eigen::Vector2d> Sideways(Comparison& comparison, double cell_m) {
  const int most = static_cast<int>(std::ceil(kMaxSidewaysM / cell_m));
  const std::optional<double> unshifted = comparison.Misfit(Eigen::Vector2d::Zero());
  if (!unshifted) return std::nullopt;
  Eigen::Vector2d best = Eigen::Vector2d::Zero();
  double least = *unshifted;
  for (int y = -most; y <= most; ++y) {
    for (int x = -most; x <= most; ++x) {
      const std::optional<double> misfit = comparison.Misfit({x, y});
      if (!misfit || *misfit >= least) continue;
      least = *misfit;
      best = {x, y};
    }
  }
  if (best.cwiseAbs().maxCoeff() >= most) return std::nullopt;
  const auto beside = [&](double x, double y) {
    return comparison.Misfit(best + Eigen::Vector2d(x, y)).value_or(least);
  };
  best += Eigen::Vector2d(LeastBetween(beside(-1, 0), least, beside(1, 0)),
                          LeastBetween(beside(0, -1), least, beside(0, 1)));
  const std::optional<double> shifted = comparison.Misfit(best);
  return shifted && *shifted < (1.0 - kMinGain) * *unshifted ? std::optional(best) : std::nullopt;
}

// How much the levels of patches scatter, those of changes left out by the median of what they are off.
std::optional<double> SpreadOfPatches(const HeightGrid& now, const HeightGrid& then,
                                      const Eigen::Vector2d& shift_cells, double up_m) {
  std::vector<double> off_m, patch_m;
  for (int top = 0; top < now.rows; top += kPatchCells) {
    for (int left = 0; left < now.columns; left += kPatchCells) {
      patch_m.clear();
      for (int row = top; row < std::min(now.rows, top + kPatchCells); ++row) {
        for (int column = left; column < std::min(now.columns, left + kPatchCells); ++column) {
          const auto cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(now.columns) +
                            static_cast<std::size_t>(column);
          const double difference_m =
              now.heights_m[cell] - Between(then, column - shift_cells.x(), row - shift_cells.y());
          if (std::isfinite(difference_m)) patch_m.push_back(difference_m);
        }
      }
      if (2 * patch_m.size() >= kPatchCells * kPatchCells)
        off_m.push_back(std::abs(MedianOf(patch_m) - up_m));
    }
  }
  if (off_m.size() < kMinPatches) return std::nullopt;
  return kSigmaOfMad * MedianOf(off_m);
}

}  // namespace

std::optional<HeightShift> ShiftBetween(const HeightGrid& now, const HeightGrid& then) {
  Comparison comparison(now, then);
  const Eigen::Vector2d cells = Sideways(comparison, now.cell_m).value_or(Eigen::Vector2d::Zero());
  std::vector<double> differences_m = comparison.Differences(cells);
  if (differences_m.size() < kMinComparedCells) return std::nullopt;
  HeightShift shift;
  shift.east_north_m = now.cell_m * Eigen::Vector2d(cells.x(), -cells.y());
  shift.up_m = MedianOf(differences_m);
  shift.sigma_m = SpreadOfPatches(now, then, cells, shift.up_m);
  return shift;
}

}  // namespace skyquilt::surface
