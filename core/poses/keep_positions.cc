#include "core/poses/keep_positions.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "core/flight/logs/log_builder.h"
#include "core/poses/evidence/common_error.h"
#include "core/poses/time/log_cover.h"

namespace skyquilt::poses {
namespace {

using flight::Photo;

// The sample nearest to a time; nothing further than a second away.
template <typename Sample>
const Sample* SampleNear(const std::vector<Sample>& samples, double t_s) {
  constexpr double kWithinS = 1.0;
  const auto next = std::lower_bound(samples.begin(), samples.end(), t_s,
                                     [](const Sample& sample, double t) { return sample.t_s < t; });
  const Sample* nearest = next == samples.end() ? nullptr : &*next;
  if (next != samples.begin() && (nearest == nullptr || t_s - (next - 1)->t_s < nearest->t_s - t_s))
    nearest = &*(next - 1);
  return nearest != nullptr && std::abs(nearest->t_s - t_s) <= kWithinS ? nearest : nullptr;
}

// By the receiver; else by how far the track goes in a second.
std::optional<Eigen::Vector3d> VelocityInEnuAt(const flight::FlightLog& log, const LogCover& cover,
                                               double t_s) {
  const auto* fix = SampleNear(log.gnss, t_s);
  if (fix != nullptr && fix->velocity_in_ned_mps) {
    const Eigen::Vector3d& in_ned_mps = *fix->velocity_in_ned_mps;
    return Eigen::Vector3d(in_ned_mps.y(), in_ned_mps.x(), -in_ned_mps.z());
  }
  const auto before = cover.PositionAt(t_s - 0.5), after = cover.PositionAt(t_s + 0.5);
  if (!before || !after) return std::nullopt;
  return Eigen::Vector3d(after->x() - before->x(), after->y() - before->y(), 0.0);
}

}  // namespace

bool AreSurveyedBesideTrack(const flight::FlightLog& log, const LogTie& tie) {
  const auto surveyed = std::count_if(tie.tied.begin(), tie.tied.end(), [&](const TiedPhoto& p) {
    const auto& position = tie.photos[p.photo].position;
    return position && position->is_rtk_fixed && position->height_ellipsoid_m;
  });
  return !log.gnss.empty() && !CommonErrorOf(log.gnss).is_corrected && 2 * surveyed > std::ssize(tie.tied);
}

void KeepPositions(const flight::FlightLog& log, LogTie& tie) {
  const LogCover cover(log);
  std::erase_if(tie.tied, [&](const TiedPhoto& p) {
    Photo& photo = tie.photos[p.photo];
    if (!photo.position) return false;
    const auto* gimbal = SampleNear(log.gimbal, p.t_s);
    const auto* turned = gimbal != nullptr ? gimbal : SampleNear(log.attitude, p.t_s);
    if (!photo.attitude && turned != nullptr && turned->has_yaw) {
      const Eigen::Vector3d angles = flight::YawPitchRollFromNed(turned->ned_from_body);
      const auto kind = gimbal != nullptr ? flight::AttitudeKind::kGimbal : flight::AttitudeKind::kAirframe;
      photo.attitude = flight::RecordedAttitude{kind, angles.x(), angles.y(), angles.z(), log.file_name};
    }
    if (!photo.velocity_in_enu_mps) photo.velocity_in_enu_mps = VelocityInEnuAt(log, cover, p.t_s);
    const auto* height = SampleNear(log.baro, p.t_s);
    if (!photo.position->height_above_takeoff_m && height != nullptr)
      photo.position->height_above_takeoff_m = height->height_above_takeoff_m;
    return true;
  });
}

}  // namespace skyquilt::poses
