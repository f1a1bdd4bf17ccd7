// ReadoutMotion: how a camera moved and turned while it read its rows, as poses and photos say, and what of
// that the adjustment may correct. Pure; any thread.
#pragma once

#include <Eigen/Core>

#include "core/camera/rolling_shutter.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// What a recorded motion during the readout may be off by, as unknowns of the adjustment: the gyro's drift
// and the speed's error grow evenly from row to row; the gyro's clock lags; rows before or after its records
// turn at a rate that changed unseen. Ten numbers a photo: turn from the first row to the last (cam, radians,
// 3), shift from the first row to the last (enu, metres, 3), turn at the end of what no record covers (cam,
// radians, 3), lag (share of the readout).
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

// From the first row of the picture, as it is stored, to the last. Still where neither speed nor turning is
// known, or not the readout. quarter_turns: by which the picture was found to be stored turned
// (PhotoFindings).
camera::RowMotion ReadoutMotion(const poses::PosedPhoto& posed, int quarter_turns);

// What of that the images may correct, for a photo whose turning is recorded.
ReadoutDoubt DoubtOfReadout(const poses::PosedPhoto& posed, int quarter_turns);

// The turns by a gyro's samples, against the middle row, as RowMotion has them; beyond its records the camera
// goes on turning as it did. Empty where they cover less than half of the readout.
std::vector<Eigen::Vector3d> TurnsOfRows(const flight::RecordedTurning& turning, double readout_s,
                                         double exposure_s);

}  // namespace skyquilt::alignment
