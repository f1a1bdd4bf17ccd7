// ReadoutMotion: how far a camera moved while it read its rows, as poses and photos say. Pure; any thread.
#pragma once

#include <Eigen/Core>

#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// From the first row of the picture, as it is stored, to the last; enu metres. Zero where speed or readout
// are not known. quarter_turns: by which the picture was found to be stored turned (CorrectedPose).
Eigen::Vector3d ReadoutMotion(const poses::PosedPhoto& posed, int quarter_turns);

}  // namespace skyquilt::alignment
