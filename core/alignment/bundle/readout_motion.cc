#include "core/alignment/bundle/readout_motion.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::alignment {
namespace {

constexpr double kKnotS = 0.004;  // between knots the rate is as good as constant: shaking is slower
constexpr int kMaxKnots = 129;
constexpr double kMinCoveredShare = 0.5;
constexpr double kGyroDriftRadps = 0.005;  // of one that is zeroed at the start
constexpr double kSpeedSigmaMps = 0.3;     // of a receiver
constexpr double kShakingRadps2 = 8.0;     // how fast rates change where nobody looks
constexpr double kLagSigmaS = 0.001;       // of its clock, found for the flight

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

// Between which moments the rows stand: each in the middle of its own exposure.
struct ReadoutTimes {
  double first_s, last_s;
};
ReadoutTimes TimesOf(double readout_s, double exposure_s) {
  return {0.5 * exposure_s, 0.5 * exposure_s + readout_s};
}

// The orientation at each moment, from the first: cam axes of that moment in those of the first sample.
std::vector<Eigen::Quaterniond> Integrated(const std::vector<flight::TurnRate>& samples) {
  std::vector<Eigen::Quaterniond> start_from_then{Eigen::Quaterniond::Identity()};
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double step_s = samples[i].time_s - samples[i - 1].time_s;
    const Eigen::Vector3d mean_radps = 0.5 * (samples[i].in_cam_radps + samples[i - 1].in_cam_radps);
    start_from_then.push_back(
        (start_from_then.back() * geo::RotationFromVector(step_s * mean_radps)).normalized());
  }
  return start_from_then;
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

std::vector<Eigen::Vector3d> TurnsOfRows(const flight::RecordedTurning& turning, double readout_s,
                                         double exposure_s) {
  const std::vector<flight::TurnRate>& samples = turning.samples;
  if (samples.size() < 2 || readout_s <= 0.0) return {};
  const ReadoutTimes rows = TimesOf(readout_s, exposure_s);
  const double covered_s =
      std::min(rows.last_s, samples.back().time_s) - std::max(rows.first_s, samples.front().time_s);
  if (covered_s < kMinCoveredShare * readout_s) return {};
  const std::vector<Eigen::Quaterniond> start_from_then = Integrated(samples);
  const auto at = [&](double time_s) {
    if (time_s <= samples.front().time_s) {
      const double before_s = time_s - samples.front().time_s;
      return geo::RotationFromVector(before_s * samples.front().in_cam_radps);
    }
    if (time_s >= samples.back().time_s) {
      const double after_s = time_s - samples.back().time_s;
      return Eigen::Quaterniond(start_from_then.back() *
                                geo::RotationFromVector(after_s * samples.back().in_cam_radps));
    }
    const auto after = std::upper_bound(samples.begin() + 1, samples.end() - 1, time_s,
                                        [](double t, const flight::TurnRate& one) { return t < one.time_s; });
    const std::size_t i = after - samples.begin();
    const double share = (time_s - samples[i - 1].time_s) / (samples[i].time_s - samples[i - 1].time_s);
    return start_from_then[i - 1].slerp(share, start_from_then[i]);
  };
  // An odd number, so that the middle row is one.
  const int knots = std::clamp(static_cast<int>(std::ceil(readout_s / kKnotS)) | 1, 3, kMaxKnots);
  const Eigen::Quaterniond start_from_middle = at(rows.first_s + 0.5 * readout_s);
  std::vector<Eigen::Vector3d> turns_rad;
  for (int k = 0; k < knots; ++k) {
    const Eigen::Quaterniond start_from_row = at(rows.first_s + readout_s * k / (knots - 1));
    turns_rad.push_back(
        geo::VectorFromRotation((start_from_row.conjugate() * start_from_middle).normalized()));
  }
  return turns_rad;
}

ReadoutDoubt DoubtOfReadout(const poses::PosedPhoto& posed, int quarter_turns) {
  const flight::Photo& photo = posed.photo;
  ReadoutDoubt doubt;
  if (!photo.turning || photo.turning->samples.empty() || !photo.readout_s || *photo.readout_s <= 0.0)
    return doubt;
  const std::vector<flight::TurnRate>& samples = photo.turning->samples;
  const ReadoutTimes rows = TimesOf(*photo.readout_s, photo.exposure_time_s.value_or(0.0));
  const double before_s = std::max(0.0, samples.front().time_s - rows.first_s);
  const double after_s = std::max(0.0, rows.last_s - samples.back().time_s);
  doubt.known_from_share = before_s / *photo.readout_s - 0.5;
  doubt.known_to_share = 0.5 - after_s / *photo.readout_s;
  const double unseen_s = std::max(before_s, after_s);
  doubt.sigma << Eigen::Vector3d::Constant(kGyroDriftRadps * *photo.readout_s),
      Eigen::Vector3d::Constant(kSpeedSigmaMps * *photo.readout_s),
      Eigen::Vector3d::Constant(0.5 * kShakingRadps2 * unseen_s * unseen_s), kLagSigmaS / *photo.readout_s;
  if (photo.is_resaved_by_viewer && quarter_turns == 2) {
    std::swap(doubt.known_from_share, doubt.known_to_share);
    doubt.known_from_share *= -1.0;
    doubt.known_to_share *= -1.0;
  }
  return doubt;
}

camera::RowMotion ReadoutMotion(const poses::PosedPhoto& posed, int quarter_turns) {
  if (posed.readout_motion) return *posed.readout_motion;
  const flight::Photo& photo = posed.photo;
  camera::RowMotion motion;
  if (!photo.readout_s) return motion;
  const bool is_turned = photo.is_resaved_by_viewer && quarter_turns != 0;
  // A camera mounted sideways still reads its own rows; a viewer that turned the picture turned those.
  if (is_turned && quarter_turns != 2) return motion;
  if (posed.velocity_in_enu_mps) motion.shift_in_enu_m = *photo.readout_s * *posed.velocity_in_enu_mps;
  if (photo.turning) {
    motion.turns_rad = TurnsOfRows(*photo.turning, *photo.readout_s, photo.exposure_time_s.value_or(0.0));
  }
  if (is_turned) {
    motion.shift_in_enu_m = -motion.shift_in_enu_m;
    std::reverse(motion.turns_rad.begin(), motion.turns_rad.end());
    for (Eigen::Vector3d& turn : motion.turns_rad) turn.head<2>() *= -1.0;  // the picture's own half turn
  }
  return motion;
}

}  // namespace skyquilt::alignment
