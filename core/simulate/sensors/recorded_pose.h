// RecordPoses: what the aircraft believes and writes into its photos: the true pose plus the errors of its
// sensors. Deterministic in the seed. Values; any thread. Sigmas after POSE notes: consumer GNSS is a slowly
// wandering common error plus a little white noise, never independent metres.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/intrinsics.h"
#include "core/flight/photo.h"
#include "core/geo/local_frame.h"
#include "core/simulate/sensors/trajectory.h"

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

}  // namespace skyquilt::simulate
