// RecordsApartOf: how far something else than the recorded positions of a flight, such as surveyed points,
// puts it from these, and how far it may: what all positions share is all that may part them. Photos that
// share their position with several others tell nothing (a receiver repeats its last fix). Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/flight/photo.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::poses {

// A receiver without corrections errs by metres. Datums that are taken for one another, and maps that are
// shifted by law, lie up to 0.8 km apart; nothing true lies further from where the camera's receiver was.
inline constexpr double kFarFromPhotosM = 1000.0;

// More photos of one camera than these at one and the same place: the receiver repeats its last fix.
inline constexpr int kMaxAtOnePlace = 2;

// One photo's: recorded minus where the flight has its camera, east and north.
struct RecordedResidual {
  Eigen::Vector2d residual_m = Eigen::Vector2d::Zero();
  const flight::RecordedPosition* record = nullptr;
};

struct RecordsApart {
  Eigen::Vector2d apart_m = Eigen::Vector2d::Zero();  // the median of each axis
  double refuting_m = 0.0;                            // five sigma of what the positions share
  double agreed_m = 0.0;                              // further apart one of the two is wrong

  bool IsContradiction() const { return apart_m.norm() > agreed_m; }
  bool IsElsewhere() const { return apart_m.norm() > kFarFromPhotosM; }
};

// `apart_m` against positions of that kind.
RecordsApart AgainstRecords(const Eigen::Vector2d& apart_m, const CommonError& common);

// Nothing of fewer than three positions that differ: among these a wrong one is told by nobody.
std::optional<RecordsApart> RecordsApartOf(const std::vector<RecordedResidual>& residuals);

}  // namespace skyquilt::poses
