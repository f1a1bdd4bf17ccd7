// The series of a flight log and of its photos as the smoother wants them: positions and heights in the local
// frame, rates thinned, noise judged from the samples themselves. Metres, seconds, radians. Pure; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/geo/local_frame.h"
#include "core/poses/smoother/smoother.h"

namespace skyquilt::poses {

// One photo with what is known of it beside its own records.
struct PhotoAtTime {
  const flight::Photo* photo = nullptr;
  double t_s = 0.0;                             // on the log's clock; without a log, on any
  double sigma_s = 0.0;                         // of this photo's time alone
  std::optional<double> height_above_ground_m;  // over the plane z = 0 of the local frame
};

struct GnssSeries {
  std::vector<PositionFix> positions;
  std::vector<VelocityFix> velocities;
  Eigen::Vector3d bias_sigma_m{1.0, 1.0, 1.8};
  bool is_rtk = false;
};
GnssSeries GnssOfLog(const std::vector<flight::GnssSample>& samples, const geo::LocalFrame& frame);

// A position of a photo as one fix; its height above the ground where the GNSS one is none to rely on.
GnssSeries GnssOfPhotos(const std::vector<PhotoAtTime>& photos, const geo::LocalFrame& frame);

// At most ten a second.
std::vector<AttitudeFix> AttitudesOfLog(const std::vector<flight::AttitudeSample>& samples);
// At most five a second, each the mean of what it stands for.
std::vector<HeightFix> HeightsOfLog(const std::vector<flight::BaroSample>& samples);
// Echoes inside the sensor's range: not the value it shows when it hears nothing.
std::vector<RangeFix> RangesOfLog(const std::vector<flight::RangeSample>& samples);

// White noise at the sample rate from the second differences of the samples (motion is smooth over three
// samples, vibration is not); doubled where slow sampling folds vibration. Nothing of too slow samples.
std::optional<ImuNoise> JudgeImu(const std::vector<flight::ImuSample>& samples);

// Where the samples neither turn nor shake: on the ground before and after the flight.
std::vector<StillInterval> FindStillness(const std::vector<flight::ImuSample>& samples);

}  // namespace skyquilt::poses
