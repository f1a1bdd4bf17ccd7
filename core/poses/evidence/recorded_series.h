// The series of a flight log and of its photos as the smoother wants them: positions and heights in the local
// frame, rates thinned, noise judged from the samples themselves. Metres, seconds, radians. Pure; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/geo/local_frame.h"
#include "core/poses/smoother/smoother.h"

namespace skyquilt::poses {

struct GnssSeries {
  std::vector<PositionFix> positions;
  std::vector<VelocityFix> velocities;
  Eigen::Vector3d bias_sigma_m{1.0, 1.0, 1.8};
  bool is_rtk = false;
};
GnssSeries GnssOfLog(const std::vector<flight::GnssSample>& samples, const geo::LocalFrame& frame);

// A position of a photo or camera event as one fix; z_in_enu_m where a better height than the GNSS one is
// known.
GnssSeries GnssOfPhotos(const std::vector<std::pair<double, const flight::Photo*>>& photos,
                        const std::vector<std::optional<double>>& heights_above_ground_m,
                        const geo::LocalFrame& frame);

// At most ten a second.
std::vector<AttitudeFix> AttitudesOfLog(const std::vector<flight::AttitudeSample>& samples);
// At most five a second, each the mean of what it stands for.
std::vector<HeightFix> HeightsOfLog(const std::vector<flight::BaroSample>& samples);
// Echoes inside the sensor's range: not the value it shows when it hears nothing.
std::vector<RangeFix> RangesOfLog(const std::vector<flight::RangeSample>& samples);

// White noise at the sample rate from the second differences of the samples (motion is smooth over three
// samples, vibration is not); doubled where slow sampling folds vibration. Nothing where the samples are too
// slow to use.
std::optional<ImuNoise> JudgeImu(const std::vector<flight::ImuSample>& samples);

// Where the samples neither turn nor shake: on the ground before and after the flight.
std::vector<StillInterval> FindStillness(const std::vector<flight::ImuSample>& samples);

}  // namespace skyquilt::poses
