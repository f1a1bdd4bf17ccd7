#include <algorithm>
#include <cmath>
#include <map>

#include "core/alignment/align_by_pose.h"
#include "core/alignment/from_records/direct_registration.h"
#include "core/alignment/stages/attempt_steps.h"
#include "core/alignment/stages/doubt_photos.h"
#include "core/alignment/stages/track_ties.h"
#include "core/base/median.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::alignment {
namespace {

using flight::Remark;
using flight::RemarkCode;

constexpr double kGoodAngleRad = 0.087;  // 5 degrees: flatter rays leave the height open

// How the aligned photos of a line moved against their records, in cam (turn) and enu (shift).
struct Learnt {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  double scatter_rad = 0.0;
  int photos = 0;
};

Learnt Learn(const std::vector<Eigen::Vector3d>& turns, const std::vector<Eigen::Vector3d>& shifts) {
  Learnt learnt;
  learnt.photos = static_cast<int>(turns.size());
  if (turns.empty()) return learnt;
  learnt.turn_rad = MedianByAxis(turns);
  learnt.shift_m = MedianByAxis(shifts);
  std::vector<Eigen::Vector3d> apart;
  for (const Eigen::Vector3d& turn : turns) apart.push_back((turn - learnt.turn_rad).cwiseAbs());
  learnt.scatter_rad = 1.5 * MedianByAxis(apart).head<2>().mean();
  return learnt;
}

std::vector<PhotoFault> Faults(const PhotoFindings& findings) {
  std::vector<PhotoFault> faults;
  if (findings.position_was_wrong) faults.push_back(PhotoFault::kPositionWrong);
  if (findings.yaw_was_wrong) faults.push_back(PhotoFault::kYawWrong);
  if (findings.quarter_turns != 0) faults.push_back(PhotoFault::kStoredTurned);
  if (findings.copy_of) faults.push_back(PhotoFault::kCopy);
  if (findings.is_blurred) faults.push_back(PhotoFault::kBlurred);
  if (findings.shows_other_place) faults.push_back(PhotoFault::kOtherPlace);
  return faults;
}

// How far off surveyed points turned out to be; nothing without any.
std::optional<double> ControlErrorM(const AlignReport& report) {
  constexpr double kSurveyM = 0.02;
  double square = 0.0;
  int points = 0;
  for (const ControlReport& point : report.control) {
    if (!point.is_used) continue;
    square += point.miss_east_m * point.miss_east_m + point.miss_north_m * point.miss_north_m;
    ++points;
  }
  if (points == 0) return std::nullopt;
  return std::max(kSurveyM, std::sqrt(square / points));
}

// Above the points that the photos show from two sides; nothing without such points.
std::optional<double> FoundHeightM(const AlignedFlight& flight) {
  std::vector<double> cameras_m;
  for (const AlignedPhoto& photo : flight.photos) {
    if (photo.placement == Placement::kAligned)
      cameras_m.push_back(photo.cam_from_enu.TargetOriginInSource().z());
  }
  if (cameras_m.empty() || flight.tie_points_in_enu.empty()) return std::nullopt;
  return Median(std::move(cameras_m)) -
         MedianOf(flight.tie_points_in_enu, [](const Eigen::Vector3d& point) { return point.z(); });
}

// Of each photo the angle off the vertical under which it sees most points that it shares with others.
void FindTiedLooks(const std::vector<Track>& tracks, const std::vector<int>& component,
                   AlignedFlight& flight) {
  constexpr std::size_t kFewestTied = 10;
  constexpr double kTiedShare = 0.9;  // the outermost are few, and may be wrong
  std::vector<std::vector<double>> looks(flight.photos.size());
  for (const Track& track : tracks) {
    for (const Observation& seen : track.observations) {
      if (component[seen.photo] < 0) continue;
      const Eigen::Vector3d down =
          flight.photos[seen.photo].cam_from_enu.TargetOriginInSource() - track.point_in_enu;
      looks[seen.photo].push_back(std::atan2(down.head<2>().norm(), down.z()));
    }
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    flight.photos[i].tied_look_rad = 0.0;
    if (looks[i].size() < kFewestTied) continue;
    flight.photos[i].tied_look_rad = Percentile(std::move(looks[i]), kTiedShare);
  }
}

void TellAssumptions(const poses::PosedFlight& posed, int aligned, AlignedFlight& flight) {
  const std::optional<double> found_m = FoundHeightM(flight);
  const std::vector<Remark> assumed =
      found_m ? poses::AssumptionsAfterAlignment(posed.assumptions, *found_m,
                                                 static_cast<int>(flight.photos.size()) - aligned)
              : poses::AssumptionsByPoses(posed.assumptions);
  flight.warnings.insert(flight.warnings.end(), assumed.begin(), assumed.end());
}

// Cameras record their absolute heights; how high above the ground they were is recorded of another ground,
// or guessed, until the photos show it. Then the map goes to where its cameras are recorded, ground and all.
void HangOnCameras(const ExtractedFlight& extracted, const poses::PosedFlight& posed, bool is_surveyed,
                   AlignedFlight& flight) {
  constexpr double kRefutedShare = 0.25;  // of the height above the ground; below it both fit
  if (!posed.hangs_on_cameras || !posed.is_placed || posed.dem_zero_m || is_surveyed) return;
  std::vector<double> below_m, flown_m;
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    const std::optional<Eigen::Vector3d>& recorded = extracted.records[i].center_in_enu;
    if (!recorded || extracted.records[i].is_unplaced) continue;
    if (flight.photos[i].placement != Placement::kAligned) continue;
    below_m.push_back(recorded->z() - flight.photos[i].cam_from_enu.TargetOriginInSource().z());
    flown_m.push_back(flight.photos[i].height_above_ground_m);
  }
  if (below_m.empty()) return;
  const double raised_m = Median(std::move(below_m));
  const bool holds = std::abs(raised_m) < kRefutedShare * Median(std::move(flown_m));
  if (holds && !posed.report.is_height_guessed) return;
  geo::Wgs84 origin = flight.frame.origin();
  origin.height_ellipsoid_m += raised_m;
  flight.frame = geo::LocalFrame(origin);
}

}  // namespace

AlignedFlight PlacePhotos(const ExtractedFlight& extracted, const Attempt& attempt,
                          const std::vector<Track>& ground_tracks, AlignReport& report) {
  const poses::PosedFlight& posed = attempt.posed;
  const BundleProblem& problem = attempt.problem;
  const std::vector<PhotoFindings>& findings = attempt.matched.findings;
  AlignedFlight flight = WithoutPhotos(posed);

  const std::optional<double> shared_error_m = ControlErrorM(report);
  const std::vector<std::string> names = posed.Names();
  std::vector<Support> support;
  const std::vector<int> component = FindAligned(problem, support);
  const std::vector<int> direct = CountTies(ViewsOf(problem), problem.soft_tracks);
  std::map<int, int> component_sizes;
  std::map<int, std::vector<Eigen::Vector3d>> turns, shifts;
  std::vector<Eigen::Vector3d> all_turns, all_shifts;
  // What the clock of a log is to blame for is not the positions' error.
  const auto by_clock_m = [&problem](std::size_t i) {
    return Eigen::Vector3d(problem.clock_error_s * problem.photos[i].by_clock_mps);
  };
  for (std::size_t i = 0; i < component.size(); ++i) {
    if (component[i] < 0) continue;
    ++component_sizes[component[i]];
    const auto& own = posed.photos[i].photo.position;
    if (findings[i].position_was_wrong || findings[i].yaw_was_wrong || (own && own->is_repeated)) continue;
    const geo::Rigid3& prior = findings[i].prior_cam_from_enu;
    const geo::Rigid3& now = problem.photos[i].cam_from_enu;
    all_turns.push_back(geo::TurnAgainst(now, prior));
    all_shifts.push_back(now.TargetOriginInSource() - prior.TargetOriginInSource() - by_clock_m(i));
    turns[problem.photos[i].line].push_back(all_turns.back());
    shifts[problem.photos[i].line].push_back(all_shifts.back());
  }
  const Learnt of_flight = Learn(all_turns, all_shifts);
  double square_shift = 0.0, square_turn = 0.0;
  for (const Eigen::Vector3d& shift : all_shifts) square_shift += shift.head<2>().squaredNorm();
  for (const Eigen::Vector3d& turn : all_turns) square_turn += turn.squaredNorm() / 3.0;
  if (!all_shifts.empty()) {
    report.position_residual_m = std::sqrt(square_shift / static_cast<double>(all_shifts.size()));
    report.attitude_residual_deg =
        geo::RadToDeg(std::sqrt(square_turn / static_cast<double>(all_turns.size())));
  }

  for (std::size_t i = 0; i < component.size(); ++i) {
    const poses::PosedPhoto& before = posed.photos[i];
    AlignedPhoto photo{.photo = before.photo,
                       .intrinsics = problem.lenses[problem.photos[i].lens].intrinsics,
                       .cam_from_enu = problem.photos[i].cam_from_enu,
                       .readout_motion = problem.photos[i].readout_motion,
                       .placement = Placement::kPoseOnly,
                       .placement_remarks = {},
                       .error_radius_m = before.error_radius_m,
                       .height_above_ground_m = before.height_above_ground_m,
                       .sharpness = {}};
    const double sigma_position = std::sqrt(before.covariance(3, 3) + before.covariance(4, 4));
    if (component[i] >= 0) {
      photo.placement = Placement::kAligned;
      // What all photos share no comparison among them can show; the rest averages out over the component.
      photo.error_radius_m = shared_error_m.value_or(sigma_position);
      photo.height_above_ground_m =
          std::max(0.5, photo.cam_from_enu.TargetOriginInSource().z() - posed.ground_z_in_enu_m);
    } else if (direct[i] > 0) {
      photo.placement_remarks = {
          {RemarkCode::kByPoseMovedToFit, {{"photos", direct[i]}, {"points", support[i].observations}}}};
    } else {
      const auto of_line = turns.find(problem.photos[i].line);
      const bool line_known = of_line != turns.end() && of_line->second.size() >= 2;
      const Learnt learnt = line_known ? Learn(of_line->second, shifts[problem.photos[i].line]) : of_flight;
      const bool learnt_enough = line_known || of_flight.photos >= 5;
      const geo::Rigid3& prior = findings[i].prior_cam_from_enu;
      photo.cam_from_enu = prior;
      if (learnt_enough) {
        photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
            (geo::RotationFromVector(learnt.turn_rad) * prior.rotation).normalized(),
            prior.TargetOriginInSource() + by_clock_m(i) + learnt.shift_m);
        photo.error_radius_m = std::min(
            before.error_radius_m,
            std::hypot(sigma_position, before.height_above_ground_m * std::max(0.003, learnt.scatter_rad)));
      }
      const std::string& unreadable = extracted.features[i].unreadable;
      photo.placement_remarks = {
          !unreadable.empty()
              ? Remark{RemarkCode::kByPoseUnreadable, {{"error_words", unreadable}}}
              : Remark{learnt_enough ? RemarkCode::kByPoseAsNeighbours : RemarkCode::kByPoseFewPoints,
                       {{"points", support[i].observations}}}};
    }
    std::vector<Remark>& said = photo.placement_remarks;
    said.insert(said.end(), findings[i].notes.begin(), findings[i].notes.end());
    photo.sharpness = findings[i].sharpness;
    for (Remark& remark : DoubtsInRemarks(findings[i], names)) said.push_back(std::move(remark));
    // As good as nowhere: the map takes it only where it has nothing else.
    if (findings[i].shows_other_place)
      photo.error_radius_m = std::max(photo.error_radius_m, before.height_above_ground_m);
    AlignPhotoReport& told = report.photo_reports[i];
    told.placement = photo.placement;
    told.remarks = said;
    told.links = support[i].tied_to;
    told.observations = support[i].observations;
    told.residual_rms_px =
        support[i].observations > 0 ? std::sqrt(support[i].square_px / support[i].observations) : 0.0;
    const auto axis_on_ground = [&posed](const geo::Rigid3& pose) {
      return AxisOnGround(pose.rotation.conjugate(), pose.TargetOriginInSource(), posed.ground_z_in_enu_m);
    };
    told.moved_m = (axis_on_ground(photo.cam_from_enu) - axis_on_ground(before.cam_from_enu)).norm();
    told.turned_deg = geo::RadToDeg(geo::TurnAgainst(photo.cam_from_enu, before.cam_from_enu).norm());
    told.faults = Faults(findings[i]);
    report.aligned += photo.placement == Placement::kAligned ? 1 : 0;
    flight.photos.push_back(std::move(photo));
  }
  for (Remark& remark : DoubtsInRemarks(findings, names)) report.corrections.push_back(std::move(remark));
  report.components = static_cast<int>(component_sizes.size());
  if (report.components == 0 && flight.photos.size() > 1) {
    flight.warnings.push_back(RemarkCode::kNoTies);
  }
  if (report.components > 1) {
    flight.warnings.push_back({RemarkCode::kGroups, {{"groups", report.components}}});
  }
  for (const Track& track : ground_tracks) {
    if (track.angle_rad < kGoodAngleRad) continue;
    const auto good = std::count_if(track.observations.begin(), track.observations.end(),
                                    [&](const Observation& one) { return component[one.photo] >= 0; });
    if (good >= 2) flight.tie_points_in_enu.push_back(track.point_in_enu);
  }
  if (report.components > 0) FindTiedLooks(ground_tracks, component, flight);
  TellAssumptions(posed, report.aligned, flight);
  HangOnCameras(extracted, posed, shared_error_m.has_value(), flight);
  const PhotoSet far_away = LeaveOutFarAway(flight);
  for (std::size_t i = 0; i < far_away.Photos(); ++i) {
    if (far_away.Has(i)) report.photo_reports[i].faults.push_back(PhotoFault::kFarAway);
  }
  return flight;
}

}  // namespace skyquilt::alignment
