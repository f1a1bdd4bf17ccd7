#include "core/alignment/bundle/readout_correction.h"

#include <algorithm>

namespace skyquilt::alignment {
namespace {

// Grows as a rate that changes evenly lets it, to one at the last row.
double Uncovered(const ReadoutDoubt& doubt, double share) {
  double reach = 0.0;
  if (share > doubt.known_to_share) {
    reach = (share - doubt.known_to_share) / (0.5 - doubt.known_to_share);
  } else if (share < doubt.known_from_share) {
    reach = (doubt.known_from_share - share) / (doubt.known_from_share + 0.5);
  }
  return reach * reach;
}

// Of row_from_middle, in the row's axes, per share of the readout.
Eigen::Vector3d RateAt(const camera::RowMotion& motion, double share) {
  const double step = 0.5 / static_cast<double>(motion.turns_rad.size() - 1);
  const double from = std::max(-0.5, share - step), to = std::min(0.5, share + step);
  return geo::VectorFromRotation((motion.TurnAt(to) * motion.TurnAt(from).conjugate()).normalized()) /
         (to - from);
}

}  // namespace

Eigen::Matrix<double, 3, kCorrectionSize> TurnByCorrection(const camera::RowMotion& motion,
                                                           const ReadoutDoubt& doubt, double share) {
  Eigen::Matrix<double, 3, kCorrectionSize> by_correction = Eigen::Matrix<double, 3, kCorrectionSize>::Zero();
  by_correction.leftCols<3>() = share * Eigen::Matrix3d::Identity();
  by_correction.middleCols<3>(6) = Uncovered(doubt, share) * Eigen::Matrix3d::Identity();
  if (motion.turns_rad.size() > 1) {
    by_correction.col(9) = motion.TurnAt(share).conjugate() * RateAt(motion, share) - RateAt(motion, 0.0);
  }
  return by_correction;
}

camera::RowMotion Corrected(const camera::RowMotion& motion, const ReadoutDoubt& doubt,
                            const ReadoutCorrection& correction) {
  camera::RowMotion corrected = motion;
  corrected.shift_in_enu_m += correction.segment<3>(3);
  if (corrected.turns_rad.empty()) corrected.turns_rad.assign(3, Eigen::Vector3d::Zero());
  const auto last = static_cast<double>(corrected.turns_rad.size() - 1);
  for (std::size_t k = 0; k < corrected.turns_rad.size(); ++k) {
    const double share = static_cast<double>(k) / last - 0.5;
    const Eigen::Vector3d turn_rad = TurnByCorrection(motion, doubt, share) * correction;
    corrected.turns_rad[k] =
        geo::VectorFromRotation((motion.TurnAt(share) * geo::RotationFromVector(turn_rad)).normalized());
  }
  return corrected;
}

}  // namespace skyquilt::alignment
