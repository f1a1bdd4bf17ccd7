#include "core/poses/evidence/position_jump.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/median.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::poses {
namespace {

using Eigen::Vector2d;

constexpr std::ptrdiff_t kOnEitherSide = 3;  // one wrong position is no jump
// Of noise without memory it is at most 2 in a thousand positions, of errors that wander 3.
constexpr double kOfSteps = 6.0;

}  // namespace

std::optional<PositionJump> JumpOf(const std::vector<Vector2d>& misses, double claimed_m) {
  PositionJump largest;
  for (auto after = misses.begin() + std::min<std::ptrdiff_t>(kOnEitherSide, std::ssize(misses));
       std::distance(after, misses.end()) >= kOnEitherSide; ++after) {
    const double by_m = (MedianByAxis(std::vector<Vector2d>(after, after + kOnEitherSide)) -
                         MedianByAxis(std::vector<Vector2d>(after - kOnEitherSide, after)))
                            .norm();
    const auto before = static_cast<std::size_t>(std::distance(misses.begin(), after)) - 1;
    if (by_m > largest.by_m) largest = {before, by_m};
  }
  std::vector<double> steps_m;
  for (std::size_t i = 1; i < misses.size(); ++i) steps_m.push_back((misses[i] - misses[i - 1]).norm());
  const double least_m =
      std::max(kFalseClaim * claimed_m, kOfSteps * MedianIfAny(std::move(steps_m)).value_or(0.0));
  return largest.by_m > least_m ? std::optional(largest) : std::nullopt;
}

}  // namespace skyquilt::poses
