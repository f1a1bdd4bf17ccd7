// FindPositionLag: whether the recorded positions of a flight are those of moments before or after the
// photos, all by the same time: a receiver that writes late, a camera that fires after it is asked to, tables
// shifted by a row. On lines flown to and fro such positions lie behind by turns on one side and the other of
// where the photos lie to each other, which shows the lag; on one straight course nothing tells it from a
// shift of the whole. Frame `enu`. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/priors.h"

namespace skyquilt::alignment {

struct PositionLag {
  double lag_s = 0.0;         // positive: the positions are those of earlier moments
  double sigma_s = 0.0;       // of it
  double median_off_m = 0.0;  // horizontal, by which it put the positions off
  // By photo, what its recorded position is to be moved by; zero for those without a line.
  std::vector<Eigen::Vector3d> correction_in_enu;
};

// Photos in the order of their times, `records` and `times_s` by photo, times rising. Nothing where the
// positions agree with the photos as they are, where a lag explains too little of what they are off by, and
// where all were taken on one course.
std::optional<PositionLag> FindPositionLag(const BundleProblem& adjusted,
                                           const std::vector<PhotoRecord>& records,
                                           const std::vector<double>& times_s);

}  // namespace skyquilt::alignment
