// What the aircraft believes and writes into its photos: the true pose plus the errors of its sensors
// (RecordPoses), and how it turned while a photo was read (RecordShaking). Deterministic in the seed. Values;
// any thread. Sigmas after POSE notes: consumer GNSS is a slowly wandering common error plus a little white
// noise, never independent metres.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/intrinsics.h"
#include "core/camera/rolling_shutter.h"
#include "core/flight/photo.h"
#include "core/geo/local_frame.h"
#include "core/simulate/sensors/trajectory.h"
#include "core/simulate/world/random.h"

namespace skyquilt::simulate {

enum class NoiseClass {
  kExact,       // the truth, to rounding; lens recorded in full
  kXmpTypical,  // consumer drone: 1.5 m wandering, tilt 0.6 deg, yaw 1.5 deg, focal length 1 % wrong, lens
                // unknown
  kRtk,         // 2 cm position with sigmas, attitude as above, lens recorded, focal length 0.1 % wrong
  kNoAttitude,  // position as kXmpTypical, no angles at all
  kNoGps,       // angles as kXmpTypical, no position and no height
  kNoPose,      // neither: only the picture, its time and its lens
};

inline constexpr double kFNumber = 2.8;

struct RecordedPose {
  std::optional<geo::Wgs84> position;
  std::optional<double> height_above_takeoff_m;
  std::optional<YawPitchRoll> gimbal;
  std::optional<YawPitchRoll> airframe;
  std::optional<Eigen::Vector3d> velocity_in_enu_mps;
  std::optional<flight::RecordedTurning> turning;  // and with it the readout time
  double readout_s = 0.0;
  double exposure_time_s = 1.0 / 1000.0;
  bool is_rtk_fixed = false;
  camera::Intrinsics intrinsics;  // as recorded
  bool is_lens_recorded = true;   // the whole lens; otherwise the focal length alone
  flight::UtcTime captured_at;    // by the camera's clock
  bool is_clock_utc = true;       // false: a local clock of 1 s resolution without zone and without GPS time
};

struct CameraClock {
  double offset_s = 0.0;          // the camera's clock minus UTC
  bool is_local_seconds = false;  // truncated to whole seconds, zone unknown
};

std::vector<RecordedPose> RecordPoses(const std::vector<TruePose>& poses, const geo::LocalFrame& frame,
                                      const camera::Intrinsics& true_intrinsics, flight::UtcTime start,
                                      NoiseClass noise, const CameraClock& clock, std::uint32_t seed);

// The Photo that reading the written file gives, without a file.
flight::Photo PhotoOfRecordedPose(const std::string& name, const RecordedPose& recorded);

inline constexpr const char* kCameraMake = "Skyquilt";
inline constexpr const char* kCameraModel = "Skyquilt Simulator";

// How a camera without gimbal turns around one exposure. Rates are sums of waves: the swaying of an aircraft
// in gusts (1 to 4 Hz), the control loop (8 to 15 Hz) and a little vibration (30 to 60 Hz). Frame cam;
// seconds since the first row began to be read.
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
