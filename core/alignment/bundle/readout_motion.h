// ReadoutMotion: how a camera moved and turned while it read its rows, as poses and photos say. Pure; any
// thread.
#pragma once

#include "core/alignment/bundle/readout_correction.h"
#include "core/camera/rolling_shutter.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// From the first row of the picture, as it is stored, to the last. Still where neither speed nor turning is
// known, or not the readout. quarter_turns: by which the picture was found to be stored turned
// (CorrectedPose).
camera::RowMotion ReadoutMotion(const poses::PosedPhoto& posed, int quarter_turns);

// What of that the images may correct, for a photo whose turning is recorded.
ReadoutDoubt DoubtOfReadout(const poses::PosedPhoto& posed, int quarter_turns);

// The turns by a gyro's samples, against the middle row, as RowMotion has them; beyond its records the camera
// goes on turning as it did. Empty where they cover less than half of the readout.
std::vector<Eigen::Vector3d> TurnsOfRows(const flight::RecordedTurning& turning, double readout_s,
                                         double exposure_s);

}  // namespace skyquilt::alignment
