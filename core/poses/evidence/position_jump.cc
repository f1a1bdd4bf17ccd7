#include "core/poses/evidence/position_jump.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/median.h"
#include "core/geo/solvers/dense_solvers.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::poses {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::ptrdiff_t kOnEitherSide = 3;  // one wrong position is no jump
// Of noise without memory it is at most 2 in a thousand positions, of errors that wander 3.
constexpr double kOfSteps = 6.0;
constexpr double kClimbShare = 0.02;  // by which a focal length that is known badly gets a climb wrong
// Times the jump, beside it: what bends beyond the second order has steps all over. Beside it and the next
// largest, where a fix was lost and found again, less.
constexpr double kOtherSteps = 0.5, kThirdSteps = 0.3;
constexpr std::size_t kOwnPositions = 2 * kOnEitherSide;  // about a jump: the step is of these
constexpr double kBendHold = 1e-6;  // equations a position, where positions say nothing of a bend

std::vector<PositionJump> StepsOf(const std::vector<Vector2d>& misses) {
  std::vector<PositionJump> steps;
  for (auto after = misses.begin() + std::min<std::ptrdiff_t>(kOnEitherSide, std::ssize(misses));
       std::distance(after, misses.end()) >= kOnEitherSide; ++after) {
    const double by_m = (MedianByAxis(std::vector<Vector2d>(after, after + kOnEitherSide)) -
                         MedianByAxis(std::vector<Vector2d>(after - kOnEitherSide, after)))
                            .norm();
    steps.push_back({static_cast<std::size_t>(std::distance(misses.begin(), after)) - 1, by_m});
  }
  return steps;
}

// What is left of heights without the tilt and the bend (a surface of second order) that fit them best.
std::vector<Vector2d> WithoutBend(const std::vector<Vector3d>& cameras_in_enu,
                                  const std::vector<double>& heights_m) {
  using Row = Eigen::Matrix<double, 6, 1>;
  Vector2d middle = Vector2d::Zero();
  for (const Vector3d& camera : cameras_in_enu)
    middle += camera.head<2>() / static_cast<double>(cameras_in_enu.size());
  double reach_m = 1.0;
  for (const Vector3d& camera : cameras_in_enu)
    reach_m = std::max(reach_m, (camera.head<2>() - middle).norm());
  std::vector<Row> rows;
  Eigen::MatrixXd normal = kBendHold * static_cast<double>(cameras_in_enu.size()) *
                           Eigen::MatrixXd::Identity(Row::SizeAtCompileTime, Row::SizeAtCompileTime);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(Row::SizeAtCompileTime);
  for (std::size_t i = 0; i < cameras_in_enu.size(); ++i) {
    const Vector2d p = (cameras_in_enu[i].head<2>() - middle) / reach_m;
    Row& row = rows.emplace_back();
    row << 1.0, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y();
    normal += row * row.transpose();
    right += heights_m[i] * row;
  }
  const Row bend = geo::SolveSymmetric(normal, right);
  std::vector<Vector2d> left;
  for (std::size_t i = 0; i < rows.size(); ++i) left.emplace_back(0.0, heights_m[i] - rows[i].dot(bend));
  return left;
}

std::size_t IndicesApart(const PositionJump& a, const PositionJump& b) {
  return std::max(a.last_before, b.last_before) - std::min(a.last_before, b.last_before);
}

// The largest step that is none of the `places` largest.
double NextLargestM(std::vector<PositionJump> steps, int places) {
  for (;; --places) {
    const auto largest =
        std::max_element(steps.begin(), steps.end(),
                         [](const PositionJump& a, const PositionJump& b) { return a.by_m < b.by_m; });
    if (largest == steps.end()) return 0.0;
    if (places == 0) return largest->by_m;
    const PositionJump found = *largest;
    std::erase_if(steps, [&](const PositionJump& step) { return IndicesApart(step, found) < kOwnPositions; });
  }
}

}  // namespace

std::optional<PositionJump> JumpOf(const std::vector<Vector2d>& misses, double claimed_m) {
  PositionJump largest;
  for (const PositionJump& step : StepsOf(misses)) {
    if (step.by_m > largest.by_m) largest = step;
  }
  std::vector<double> steps_m;
  for (std::size_t i = 1; i < misses.size(); ++i) steps_m.push_back((misses[i] - misses[i - 1]).norm());
  const double least_m =
      std::max(kFalseClaim * claimed_m, kOfSteps * MedianIfAny(std::move(steps_m)).value_or(0.0));
  return largest.by_m > least_m ? std::optional(largest) : std::nullopt;
}

std::optional<PositionJump> HeightJumpOf(const std::vector<Vector3d>& cameras_in_enu,
                                         const std::vector<double>& misses_m, double claimed_m) {
  const std::vector<Vector2d> misses = WithoutBend(cameras_in_enu, misses_m);
  const std::optional<PositionJump> jump = JumpOf(misses, claimed_m);
  if (!jump) return std::nullopt;
  std::vector<Vector2d> flown;
  for (const Vector3d& camera : cameras_in_enu) flown.emplace_back(0.0, camera.z());
  double climbed_m = 0.0;
  for (const PositionJump& climb : StepsOf(flown)) {
    if (IndicesApart(climb, *jump) < static_cast<std::size_t>(kOnEitherSide))
      climbed_m = std::max(climbed_m, climb.by_m);
  }
  const bool is_of_climb = jump->by_m - kClimbShare * climbed_m <= kFalseClaim * claimed_m;
  const std::vector<PositionJump> steps = StepsOf(misses);
  const bool is_of_shape =
      NextLargestM(steps, 1) > kOtherSteps * jump->by_m && NextLargestM(steps, 2) > kThirdSteps * jump->by_m;
  return is_of_climb || is_of_shape ? std::nullopt : jump;
}

}  // namespace skyquilt::poses
