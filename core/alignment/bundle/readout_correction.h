// What a recorded motion during the readout may be off by, as unknowns of the adjustment: the gyro's drift
// and the speed's error grow evenly from row to row; the gyro's clock lags; rows before or after its records
// turn at a rate that changed unseen. Ten numbers a photo: turn from the first row to the last (cam, radians,
// 3), shift from the first row to the last (enu, metres, 3), turn at the end of what no record covers (cam,
// radians, 3), lag (share of the readout). Pure; any thread.
#pragma once

#include <Eigen/Core>

#include "core/camera/rolling_shutter.h"

namespace skyquilt::alignment {

inline constexpr int kCorrectionSize = 10;
using ReadoutCorrection = Eigen::Matrix<double, kCorrectionSize, 1>;

struct ReadoutDoubt {
  ReadoutCorrection sigma = ReadoutCorrection::Zero();   // all zero: the motion is taken as it is
  double known_from_share = -0.5, known_to_share = 0.5;  // rows that the gyro's records cover

  bool IsAny() const { return sigma.maxCoeff() > 0.0; }
};

// The turn that a correction adds to a row, before row_from_middle: by which matrix.
Eigen::Matrix<double, 3, kCorrectionSize> TurnByCorrection(const camera::RowMotion& motion,
                                                           const ReadoutDoubt& doubt, double share);

// The motion with the correction in it.
camera::RowMotion Corrected(const camera::RowMotion& motion, const ReadoutDoubt& doubt,
                            const ReadoutCorrection& correction);

}  // namespace skyquilt::alignment
