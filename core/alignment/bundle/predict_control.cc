#include "core/alignment/bundle/predict_control.h"

#include <cstddef>

namespace skyquilt::alignment {
namespace {

// Observations times adjustments: about two minutes of one core.
constexpr std::size_t kMaxPredictedObservations = 20'000'000;

std::size_t ObservationsOf(const BundleProblem& problem) {
  std::size_t observations = 0;
  for (const auto* tracks : {&problem.tracks, &problem.soft_tracks}) {
    for (const Track& track : *tracks) observations += track.observations.size();
  }
  return observations;
}

}  // namespace

void PredictControl(const BundleProblem& problem, std::vector<ControlReport>& reports) {
  const std::size_t points = problem.control.size();
  if (points < kMinPredictedPoints || points * ObservationsOf(problem) > kMaxPredictedObservations) return;
  BundleOptions once;
  once.cuts_px = {0.0};
  for (std::size_t left = 0; left < points; ++left) {
    BundleProblem others = problem;
    others.control.erase(others.control.begin() + static_cast<std::ptrdiff_t>(left));
    if (AdjustBundle(others, once).termination == BundleTermination::kFailed) continue;
    const BundleControl& point = problem.control[left];
    Track seen = point.track;
    if (!Triangulate(ViewsOf(others), seen)) continue;
    const Eigen::Vector3d apart = seen.point_in_enu - point.surveyed_in_enu;
    reports[point.report].left_out =
        ControlPrediction{apart.x(), apart.y(), point.has_height ? apart.z() : 0.0};
  }
}

}  // namespace skyquilt::alignment
