#include "core/alignment/bundle/find_readout.h"

#include <cmath>

#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

constexpr double kRobustSigmas = 2.5;  // as the adjustment has it
constexpr double kShowsSigmas = 4.0;
constexpr double kExplainsSigmas = 8.0;
constexpr double kShortestReadoutS = 0.003, kLongestReadoutS = 0.25;
constexpr double kReadoutStepS = 0.001;

struct Weighed {
  double observed = 0.0;  // sum of weight * derivative * residual
  double square = 0.0;    // sum of weight * derivative^2
  std::vector<double> errors_in_sigmas;
};

std::optional<Eigen::Vector2d> Projected(const View& view, const Observation& seen,
                                         const Eigen::Vector3d& shift_in_enu_m,
                                         const Eigen::Vector3d& point_in_enu) {
  geo::Rigid3 pose = view.CamFromEnuAt(seen.pixel_in_image);
  pose =
      geo::Rigid3::FromRotationAndTargetOrigin(pose.rotation, pose.TargetOriginInSource() + shift_in_enu_m);
  return view.intrinsics.Project(pose * point_in_enu);
}

// The observations' cost by Cauchy's loss, in squared sigmas.
double CostOf(const BundleProblem& problem, int lens, std::vector<double>& errors_in_sigmas) {
  const std::vector<View> views = ViewsOf(problem);
  double cost = 0.0;
  for (const Track& track : problem.tracks) {
    for (const Observation& seen : track.observations) {
      if (problem.photos[seen.photo].lens != lens) continue;
      const double error = ReprojectionErrorPx(views[seen.photo], seen, track.point_in_enu) / seen.sigma_px;
      errors_in_sigmas.push_back(error);
      cost += kRobustSigmas * kRobustSigmas * std::log1p(error * error / (kRobustSigmas * kRobustSigmas));
    }
  }
  return cost;
}

}  // namespace

std::vector<int> LensesThatMayRoll(const BundleProblem& adjusted, const PhotoSet& may_roll) {
  const std::vector<View> views = ViewsOf(adjusted);
  std::vector<Weighed> of_lens(adjusted.lenses.size());
  for (const Track& track : adjusted.tracks) {
    for (const Observation& seen : track.observations) {
      const BundlePhoto& photo = adjusted.photos[seen.photo];
      if (!may_roll.Has(seen.photo) || !photo.velocity_in_enu_mps || photo.is_fixed) continue;
      const View& view = views[seen.photo];
      const double share = camera::RowShare(seen.pixel_in_image.y(), view.intrinsics.height_px);
      const auto at = Projected(view, seen, Eigen::Vector3d::Zero(), track.point_in_enu);
      const auto after =
          Projected(view, seen, kReadoutStepS * share * *photo.velocity_in_enu_mps, track.point_in_enu);
      if (!at || !after) continue;
      const Eigen::Vector2d residual = (*at - seen.pixel_in_image) / seen.sigma_px;
      const Eigen::Vector2d derivative = (*after - *at) / (kReadoutStepS * seen.sigma_px);
      const double weight = 1.0 / (1.0 + residual.squaredNorm() / (kRobustSigmas * kRobustSigmas));
      Weighed& weighed = of_lens[photo.lens];
      weighed.observed += weight * derivative.dot(residual);
      weighed.square += weight * derivative.squaredNorm();
      weighed.errors_in_sigmas.push_back(residual.norm());
    }
  }
  std::vector<int> lenses;
  for (std::size_t c = 0; c < of_lens.size(); ++c) {
    Weighed& weighed = of_lens[c];
    if (adjusted.lenses[c].is_fixed || weighed.square <= 0.0) continue;
    const double spread = Median(std::move(weighed.errors_in_sigmas)) / kMedianInPlane;
    // What poses and points took over of it does not count here, so that it is rather more than this.
    if (std::abs(weighed.observed) > kShowsSigmas * spread * std::sqrt(weighed.square))
      lenses.push_back(static_cast<int>(c));
  }
  return lenses;
}

std::vector<int> LensesThatRoll(const BundleProblem& adjusted, const std::vector<int>& lenses) {
  BundleProblem still = adjusted;
  for (BundlePhoto& photo : still.photos) {
    BundleLens& lens = still.lenses[photo.lens];
    if (!lens.finds_readout || !photo.velocity_in_enu_mps || photo.is_fixed) continue;
    photo.readout_motion.shift_in_enu_m -= lens.readout_s * *photo.velocity_in_enu_mps;
  }
  for (BundleLens& lens : still.lenses) {
    lens.finds_readout = false;
    lens.readout_s = 0.0;
  }
  AdjustBundle(still, {.cuts_px = {1e9}});  // the same observations
  std::vector<int> rolling;
  for (const int c : lenses) {
    const double readout_s = std::abs(adjusted.lenses[c].readout_s);
    if (readout_s < kShortestReadoutS || readout_s > kLongestReadoutS) continue;
    std::vector<double> errors, errors_when_still;
    const double cost = CostOf(adjusted, c, errors);
    const double cost_when_still = CostOf(still, c, errors_when_still);
    if (errors.empty()) continue;
    const double spread = Median(std::move(errors)) / kMedianInPlane;
    if (cost_when_still - cost > kExplainsSigmas * kExplainsSigmas * spread * spread) rolling.push_back(c);
  }
  return rolling;
}

}  // namespace skyquilt::alignment
