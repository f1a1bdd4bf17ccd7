// Shaking: how a camera without gimbal turns around one exposure, and what its gyro writes of that. Rates are
// sums of waves: the swaying of an aircraft in gusts (1 to 4 Hz), the control loop (8 to 15 Hz) and a little
// vibration (30 to 60 Hz). Frame cam; seconds since the first row began to be read. Deterministic. Values;
// any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/camera/rolling_shutter.h"
#include "core/flight/photo.h"
#include "core/simulate/world/random.h"

namespace skyquilt::simulate {

class Shaking {
 public:
  // rate_radps: 1-sigma about each axis, over many photos.
  Shaking(double rate_radps, RandomStream& random);
  Eigen::Vector3d RateInCam(double time_s) const;

  // Against the middle row, while the rows are read, each in the middle of its exposure.
  std::vector<Eigen::Vector3d> TurnsOfRows(double readout_s, double exposure_s) const;

 private:
  struct Wave {
    Eigen::Vector3d sine_radps, cosine_radps;
    double turns_per_s;
  };
  std::vector<Wave> waves_;
};

// What the gyro writes: a sample a millisecond, from 10 ms before the first row to 10 ms after the last, by a
// filter that answers kGyroLagS late.
inline constexpr double kGyroLagS = 0.012;
struct GyroModel {
  double noise_radps = 0.0;  // 1-sigma of each sample
  double bias_radps = 0.0;   // 1-sigma of each photo
};
flight::RecordedTurning RecordShaking(const Shaking& shaking, double readout_s, const GyroModel& model,
                                      RandomStream& random);

}  // namespace skyquilt::simulate
