#include "core/alignment/bundle/control_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

using flight::RemarkCode;

constexpr double kSightingSigmaPx = 1.0;
constexpr double kFarOffM = 2.0;
constexpr double kFarOffMads = 8.0;
constexpr double kWrongMarkShare = 0.01;  // of a photo's width, off where the other marks put the point
constexpr std::size_t kMinMarks = 2;
// Observations times adjustments: about two minutes of one core.
constexpr std::size_t kMaxPredictedObservations = 20'000'000;

// The largest error of a mark, in widths of its photo; endless where the marks do not meet.
double WorstMarkShare(const std::vector<View>& views, Track& track) {
  if (!Triangulate(views, track)) return std::numeric_limits<double>::infinity();
  double worst = 0.0;
  for (const Observation& mark : track.observations) {
    const View& view = views[mark.photo];
    worst = std::max(worst, ReprojectionErrorPx(view, mark, track.point_in_enu) / view.intrinsics.width_px);
  }
  return worst;
}

// While the marks do not agree, one goes: that without which the others agree best. Their photos.
std::vector<int> DropWrongMarks(const std::vector<View>& views, Track& track) {
  std::vector<int> dropped;
  while (track.observations.size() > kMinMarks && WorstMarkShare(views, track) > kWrongMarkShare) {
    std::size_t wrong = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < track.observations.size(); ++k) {
      Track others = track;
      others.observations.erase(others.observations.begin() + static_cast<std::ptrdiff_t>(k));
      const double worst = WorstMarkShare(views, others);
      if (worst >= least) continue;
      least = worst;
      wrong = k;
    }
    if (!std::isfinite(least)) break;
    dropped.push_back(track.observations[wrong].photo);
    track.observations.erase(track.observations.begin() + static_cast<std::ptrdiff_t>(wrong));
  }
  return dropped;
}

// Where the photos alone say the point is, against where it was surveyed; nothing where they do not.
std::optional<Eigen::Vector3d> SeenFromSurveyed(const std::vector<View>& views, const BundleControl& tied) {
  Track seen = tied.track;
  if (!Triangulate(views, seen)) return std::nullopt;
  return Eigen::Vector3d(seen.point_in_enu - tied.surveyed_in_enu);
}

// It is no observation; its point still is.
void LeaveOutHeight(double off_m, BundleControl& tied, std::vector<ControlReport>& reports) {
  tied.has_height = false;
  tied.surveyed_in_enu.z() = tied.track.point_in_enu.z();
  flight::Remark why{RemarkCode::kPointHeightFarFromOthers, {{"apart_m", off_m}}};
  std::optional<flight::Remark>& reason = reports[tied.report].reason;
  reason = reason
               ? flight::Remark{RemarkCode::kPointNotedTwice, {{"first", *reason}, {"then", std::move(why)}}}
               : std::move(why);
}

void LeaveOutEmptyHeights(const std::vector<ControlPoint>& control, BundleProblem& problem,
                          std::vector<ControlReport>& reports) {
  std::vector<std::optional<double>> surveyed_m;
  std::vector<double> shown_m;
  for (const BundleControl& tied : problem.control) {
    surveyed_m.push_back(control[tied.report].height_m);
    shown_m.push_back(tied.track.point_in_enu.z());
  }
  const std::vector<std::optional<double>> off_m = HeightsLeftEmpty(surveyed_m, shown_m);
  for (std::size_t k = 0; k < off_m.size(); ++k) {
    if (off_m[k]) LeaveOutHeight(*off_m[k], problem.control[k], reports);
  }
}

// Those that lie far off where most of the others put them.
void LeaveOutWrongHeights(BundleProblem& problem, std::vector<ControlReport>& reports) {
  std::vector<double> residuals_m;
  for (const BundleControl& tied : problem.control) {
    if (tied.has_height)
      residuals_m.push_back(std::abs(tied.surveyed_in_enu.z() - tied.track.point_in_enu.z()));
  }
  if (residuals_m.size() < kEnoughToVote) return;
  const double limit_m = kFarOffM + kFarOffMads * Median(std::move(residuals_m));
  for (BundleControl& tied : problem.control) {
    const double off_m = std::abs(tied.surveyed_in_enu.z() - tied.track.point_in_enu.z());
    if (tied.has_height && off_m > limit_m) LeaveOutHeight(off_m, tied, reports);
  }
}

std::size_t ObservationsOf(const BundleProblem& problem) {
  std::size_t observations = 0;
  for (const auto* tracks : {&problem.tracks, &problem.soft_tracks}) {
    for (const Track& track : *tracks) observations += track.observations.size();
  }
  return observations;
}

// Two points that disagree: nothing tells which of them is wrong.
std::optional<flight::Remark> Disagreement(const std::vector<ControlReport>& points) {
  std::vector<const ControlReport*> used;
  for (const ControlReport& point : points) {
    if (point.is_used && !point.is_check) used.push_back(&point);
  }
  if (used.size() != 2) return std::nullopt;
  const double apart_m =
      std::hypot(used[0]->miss_east_m - used[1]->miss_east_m, used[0]->miss_north_m - used[1]->miss_north_m);
  if (apart_m <= kNoSurveyM) return std::nullopt;
  return flight::Remark{RemarkCode::kControlPairDisagrees,
                        {{"point", used[0]->name}, {"other", used[1]->name}, {"apart_m", apart_m}}};
}

bool IsOfList(const flight::Remark& reason) {
  return reason.code == RemarkCode::kControlOfOtherPixels || reason.code == RemarkCode::kControlElsewhere;
}

}  // namespace

MarkedPhotos::MarkedPhotos(const std::vector<std::string>& names, const std::vector<View>& views,
                           const PhotoSet& tied)
    : names_(names), views_(views), tied_(tied) {
  for (std::size_t i = 0; i < names.size(); ++i) number_of_.emplace(names[i], i);
}

std::vector<Observation> MarkedPhotos::MarksOf(const ControlPoint& point) const {
  std::vector<Observation> marks;
  for (const ControlSighting& sighting : point.sightings) {
    const auto photo = number_of_.find(sighting.photo_name);
    if (photo == number_of_.end() || !views_[photo->second].intrinsics.IsInImage(sighting.pixel_in_image))
      continue;
    marks.push_back({photo->second, sighting.pixel_in_image, kSightingSigmaPx});
  }
  return marks;
}

std::size_t MarkedPhotos::TiedMarksOf(const ControlPoint& point) const {
  std::size_t tied = 0;
  for (const Observation& mark : MarksOf(point)) tied += tied_.Has(mark.photo) ? 1 : 0;
  return tied < kMinMarks ? 0 : tied;
}

std::optional<Track> MarkedPhotos::TrackOf(const ControlPoint& point, ControlReport& told) const {
  told.name = point.name;
  told.surveyed = point.position;
  told.system_error_m = point.system_error_m;
  Track track;
  for (const Observation& mark : MarksOf(point)) {
    ++told.sightings;
    if (tied_.Has(mark.photo)) track.observations.push_back(mark);
  }
  if (track.observations.size() < kMinMarks) {
    told.reason = RemarkCode::kPointFewMarks;
    return std::nullopt;
  }
  std::vector<std::string> elsewhere;
  for (const int photo : DropWrongMarks(views_, track)) elsewhere.push_back(names_[photo]);
  if (!elsewhere.empty()) {
    told.reason = {RemarkCode::kPointMarksElsewhere,
                   {{"marks", elsewhere.size()}, {"names", fmt::format("{}", fmt::join(elsewhere, ", "))}}};
  }
  if (!Triangulate(views_, track)) {
    told.reason = RemarkCode::kPointMarksApart;
    return std::nullopt;
  }
  return track;
}

std::vector<ControlMarkReport> MarkedPhotos::ResidualsOf(const ControlPoint& point,
                                                         const Eigen::Vector3d& point_in_enu,
                                                         const std::optional<Track>& used) const {
  std::vector<ControlMarkReport> residuals;
  for (const Observation& mark : MarksOf(point)) {
    const double residual_px = ReprojectionErrorPx(views_[mark.photo], mark, point_in_enu);
    if (!std::isfinite(residual_px)) continue;  // behind the camera
    const bool is_used = used && std::any_of(used->observations.begin(), used->observations.end(),
                                             [&](const Observation& one) { return one.photo == mark.photo; });
    residuals.push_back({names_[mark.photo], residual_px, residual_px * views_[mark.photo].GsdM(), is_used});
  }
  return residuals;
}

std::vector<std::optional<double>> HeightsLeftEmpty(const std::vector<std::optional<double>>& surveyed_m,
                                                    const std::vector<double>& shown_m) {
  constexpr std::size_t kFewestOthers = 2;  // with one nothing tells which is wrong
  std::vector<double> others_m;             // surveyed above shown
  for (std::size_t k = 0; k < surveyed_m.size(); ++k) {
    if (surveyed_m[k] && *surveyed_m[k] != 0.0) others_m.push_back(*surveyed_m[k] - shown_m[k]);
  }
  std::vector<std::optional<double>> off_m(surveyed_m.size());
  if (others_m.size() < kFewestOthers) return off_m;
  const double above_m = Median(others_m);
  for (double& other_m : others_m) other_m = std::abs(other_m - above_m);
  const double limit_m = kFarOffM + kFarOffMads * Median(std::move(others_m));
  for (std::size_t k = 0; k < surveyed_m.size(); ++k) {
    const double apart_m = std::abs(shown_m[k] + above_m);
    if (surveyed_m[k] == 0.0 && apart_m > limit_m) off_m[k] = apart_m;
  }
  return off_m;
}

void TieToControl(const poses::PosedFlight& posed, const std::vector<ControlPoint>& control,
                  BundleProblem& problem, std::vector<ControlReport>& reports) {
  problem.control.clear();
  reports.clear();
  const PhotoSet tied_photos = ObservingPhotos(problem.photos.size(), problem.tracks);
  const std::vector<std::string> names = posed.Names();
  const std::vector<View> views = ViewsOf(problem);
  const MarkedPhotos photos(names, views, tied_photos);

  std::vector<std::size_t> marks_tied;
  for (const ControlPoint& point : control) {
    marks_tied.push_back(photos.TiedMarksOf(point));
    std::optional<Track> track = photos.TrackOf(point, reports.emplace_back());
    if (!track) continue;
    BundleControl tied;
    tied.track = *std::move(track);
    tied.has_height = point.height_m.has_value();
    tied.surveyed_in_enu = posed.frame.EnuFromWgs84(
        {point.position.lat_deg, point.position.lon_deg,
         posed.frame.origin().height_ellipsoid_m + point.height_m.value_or(tied.track.point_in_enu.z())});
    // Its height may count from any zero: as high as that the place would lie further out, as seen from the
    // middle of the Earth, and a survey of mountains would be too large.
    if (point.height_m) {
      const double shown_z_m = tied.track.point_in_enu.z();
      tied.surveyed_in_enu.head<2>() = posed.frame.EnuAtHeight(point.position, shown_z_m).head<2>();
    }
    tied.sigma_m = {point.sigma_horizontal_m, point.sigma_horizontal_m, point.sigma_vertical_m};
    tied.report = reports.size() - 1;
    problem.control.push_back(std::move(tied));
  }
  RefuseControl(posed, control, marks_tied, tied_photos, problem, reports);
  if (problem.control.empty()) return;

  LeaveOutEmptyHeights(control, problem, reports);
  // The block goes where most points want it; heights of the survey come to the block's zero.
  Eigen::Vector3d shift;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> apart;
    for (const BundleControl& tied : problem.control) {
      if (axis == 2 && !tied.has_height) continue;
      apart.push_back(tied.surveyed_in_enu[axis] - tied.track.point_in_enu[axis]);
    }
    shift[axis] = apart.empty() ? 0.0 : Median(apart);
  }
  for (BundleControl& tied : problem.control) {
    if (tied.has_height) tied.surveyed_in_enu.z() -= shift.z();
  }
  shift.z() = 0.0;
  if (problem.control.size() >= kEnoughToVote) {
    std::vector<double> residuals;
    for (const BundleControl& tied : problem.control) {
      residuals.push_back((tied.surveyed_in_enu - tied.track.point_in_enu - shift).head<2>().norm());
    }
    const double limit_m = kFarOffM + kFarOffMads * Median(residuals);
    std::size_t k = 0;
    std::erase_if(problem.control, [&](const BundleControl& tied) {
      const double residual_m = residuals[k++];
      if (residual_m <= limit_m) return false;
      reports[tied.report].reason = {RemarkCode::kPointFarFromOthers, {{"apart_m", residual_m}}};
      return true;
    });
  }
  LeaveOutWrongHeights(problem, reports);
  for (const BundleControl& tied : problem.control) reports[tied.report].is_used = true;
  problem.position_bias_m = shift;
  for (BundlePhoto& photo : problem.photos) {
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
        photo.cam_from_enu.rotation, photo.cam_from_enu.TargetOriginInSource() + shift);
  }
  for (auto* tracks : {&problem.tracks, &problem.soft_tracks}) {
    for (Track& track : *tracks) track.point_in_enu += shift;
  }
  for (BundleControl& tied : problem.control) tied.track.point_in_enu += shift;
}

bool BelieveContradictedControlLess(BundleProblem& problem) {
  const std::vector<View> views = ViewsOf(problem);
  std::vector<double> residuals_m;
  for (const BundleControl& tied : problem.control) {
    if (const auto apart = SeenFromSurveyed(views, tied)) residuals_m.push_back(apart->head<2>().norm());
  }
  if (residuals_m.size() < kMinContradicted) return false;
  const double residual_m = Median(std::move(residuals_m));
  if (residual_m < kNoSurveyM) return false;
  for (BundleControl& tied : problem.control) tied.sigma_m = tied.sigma_m.cwiseMax(residual_m);
  return true;
}

void ReportControl(const BundleProblem& problem, std::vector<ControlReport>& reports) {
  const std::vector<View> views = ViewsOf(problem);
  for (const BundleControl& tied : problem.control) {
    ControlReport& told = reports[tied.report];
    const std::optional<Eigen::Vector3d> apart = SeenFromSurveyed(views, tied);
    if (!apart) continue;
    told.miss_east_m = apart->x();
    told.miss_north_m = apart->y();
    told.miss_up_m = tied.has_height ? apart->z() : kNotComparedM;
    double square = 0.0;
    for (const Observation& one : tied.track.observations) {
      square += std::pow(ReprojectionErrorPx(views[one.photo], one, tied.surveyed_in_enu), 2);
    }
    told.residual_px = std::sqrt(square / static_cast<double>(tied.track.observations.size()));
  }
}

std::vector<flight::Remark> RemarksOn(const std::vector<ControlReport>& points) {
  std::vector<flight::Remark> remarks;
  const std::optional<flight::Remark> disagreement = Disagreement(points);
  if (disagreement) remarks.push_back(*disagreement);
  for (const ControlReport& point : points) {
    if (point.reason && IsOfList(*point.reason)) {  // said once for all its points
      if (std::find(remarks.begin(), remarks.end(), *point.reason) == remarks.end())
        remarks.push_back(*point.reason);
      continue;
    }
    const double residual_m = std::hypot(point.miss_east_m, point.miss_north_m);
    std::map<std::string, flight::RemarkValue> values{{"point", point.name}};
    if (point.reason) values.emplace("reason", *point.reason);
    if (!point.is_used) {
      remarks.push_back({RemarkCode::kControlNotUsed, std::move(values)});
      continue;
    }
    if (residual_m > kNoSurveyM && !disagreement) {
      values.emplace("apart_m", residual_m);
      remarks.push_back({point.reason ? RemarkCode::kControlFarOffAndNoted : RemarkCode::kControlFarOff,
                         std::move(values)});
    } else if (point.reason) {
      remarks.push_back({RemarkCode::kControlNoted, std::move(values)});
    }
    if (std::abs(point.miss_up_m) > kNoSurveyUpM) {
      remarks.push_back(
          {RemarkCode::kControlHeightOff, {{"point", point.name}, {"apart_m", std::abs(point.miss_up_m)}}});
    }
  }
  return remarks;
}

void PredictControl(const BundleProblem& problem, std::vector<ControlReport>& reports) {
  const std::size_t points = problem.control.size();
  if (points < kMinPredictedPoints || points * ObservationsOf(problem) > kMaxPredictedObservations) return;
  for (std::size_t left = 0; left < points; ++left) {
    BundleProblem others = problem;
    others.control.erase(others.control.begin() + static_cast<std::ptrdiff_t>(left));
    if (AdjustBundle(others, {.cuts_px = {0.0}}).has_failed) continue;
    const BundleControl& point = problem.control[left];
    const std::optional<Eigen::Vector3d> apart = SeenFromSurveyed(ViewsOf(others), point);
    if (!apart) continue;
    reports[point.report].left_out =
        ControlPrediction{apart->x(), apart->y(), point.has_height ? apart->z() : kNotComparedM};
  }
}

}  // namespace skyquilt::alignment
