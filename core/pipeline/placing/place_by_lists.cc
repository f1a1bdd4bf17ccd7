#include "core/pipeline/placing/place_by_lists.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "core/alignment/bundle/control_points.h"
#include "core/alignment/matching/verified_pair.h"
#include "core/alignment/scene/matches.h"
#include "core/base/median.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/lat_lon.h"
#include "core/pipeline/placing/control_points.h"
#include "core/pipeline/placing/move_flight.h"
#include "core/pipeline/placing/place_known.h"
#include "core/pipeline/report/judge_map.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::pipeline {
namespace {

using alignment::AlignedPhoto;
using alignment::GroundSimilarity;
using Complex = std::complex<double>;

constexpr std::size_t kMaxPoints = 4;
constexpr double kTurningSpread = 0.2;  // of the flight's extent: points nearer together tell no turn
constexpr double kMaxStretch = 0.05;
constexpr double kMaxTurnRad = 0.05;
constexpr double kSurveyM = 0.02;
constexpr double kMaxResidualGsds = 4.0;  // of points after the move
constexpr double kNoMoveGsds = 0.02;      // less is not worth another map

struct Tied {
  Complex now, surveyed;
  std::size_t report = 0;  // number of the point
};

Complex EastNorth(const Eigen::Vector3d& point_in_enu) { return {point_in_enu.x(), point_in_enu.y()}; }

std::vector<Tied> TiePoints(const FlightFacts& known, const std::vector<alignment::ControlPoint>& control,
                            std::vector<alignment::ControlReport>& reports) {
  std::vector<Tied> tied;
  for (const MarkedPoint& marked : MarkedPointsOf(known, control, reports)) {
    const Eigen::Vector3d surveyed =
        known.flight.frame.EnuAtHeight(marked.point.position, marked.seen_in_enu.z());
    tied.push_back({EastNorth(marked.seen_in_enu), EastNorth(surveyed), marked.report});
  }
  return tied;
}

GroundSimilarity FitMove(const std::vector<Tied>& tied, double extent_m) {
  std::vector<std::pair<Complex, Complex>> places;
  double spread_m = 0.0;
  Complex shift(0.0, 0.0);
  for (const Tied& one : tied) {
    places.emplace_back(one.now, one.surveyed);
    spread_m = std::max(spread_m, std::abs(one.now - tied.front().now));
    shift += (one.surveyed - one.now) / static_cast<double>(tied.size());
  }
  if (spread_m < kTurningSpread * extent_m || spread_m == 0.0) return {{1.0, 0.0}, shift};
  return alignment::FitSimilarity(places);
}

std::vector<const flight::RecordedPosition*> RecordsOf(const FlightFacts& facts) {
  std::vector<const flight::RecordedPosition*> records;
  for (const AlignedPhoto& photo : facts.flight.photos) {
    if (photo.photo.position) records.push_back(&*photo.photo.position);
  }
  return records;
}

// Corrected positions know the map's turn and scale better than a few points of which one may be wrong, and
// which any two fit.
bool ContradictCorrected(const FlightFacts& known, const std::vector<alignment::ControlPoint>& control) {
  if (control.size() > kMaxPoints || known.is_by_hand) return false;
  const std::vector<const flight::RecordedPosition*> records = RecordsOf(known);
  const bool is_corrected =
      records.empty() ? known.poses_report.log_is_corrected : poses::CommonErrorOf(records).is_corrected;
  if (!is_corrected) return false;
  std::vector<alignment::ControlReport> ignored;
  const std::vector<Tied> tied = TiePoints(known, control, ignored);
  const double limit_m = std::max(alignment::kNoSurveyM, kSurveyM + kMaxResidualGsds * MedianGsdM(known));
  return std::any_of(tied.begin(), tied.end(), [&](const Tied& one) {
    const Tied& first = tied.front();
    return std::abs((one.surveyed - one.now) - (first.surveyed - first.now)) > limit_m;
  });
}

// One of them may be wrong, and nothing tells which. Against a scale or north that is a guess, or somebody's
// word, they do not stand: there they are too few.
bool AreTwo(const FlightFacts& known, const std::vector<alignment::ControlPoint>& control) {
  if (known.is_by_hand) return false;
  if (known.align_report && (known.align_report->by_images.is_scale_guessed.value_or(false) ||
                             known.align_report->by_images.is_north_guessed.value_or(false)))
    return false;
  std::vector<alignment::ControlReport> ignored;
  return control.size() <= kMaxPoints && TiePoints(known, control, ignored).size() == 2;
}

// Each point by a move that the others alone say.
void Predict(const std::vector<Tied>& tied, double extent_m, std::vector<alignment::ControlReport>& reports) {
  if (tied.size() < alignment::kMinPredictedPoints) return;
  for (std::size_t left = 0; left < tied.size(); ++left) {
    std::vector<Tied> others = tied;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left));
    const Complex miss = FitMove(others, extent_m) * tied[left].now - tied[left].surveyed;
    reports[tied[left].report].left_out =
        alignment::ControlPrediction{miss.real(), miss.imag(), alignment::kNotComparedM};
  }
}

void Forget(flight::RemarkCode code, std::vector<flight::Remark>& warnings) {
  std::erase_if(warnings, [&](const flight::Remark& said) { return said.code == code; });
}

// MoveToControl, however far that is.
std::optional<FlightFacts> MovedToControl(const FlightFacts& known,
                                          const std::vector<flight::GcpList>& lists) {
  const std::vector<alignment::ControlPoint> control = ControlPointsOf(lists);
  // Points that only check the map leave it where it is.
  if (control.empty() && !CheckPointsOf(lists).empty()) return known;
  if (control.empty() || control.size() > kMaxPoints || known.flight.photos.empty()) return std::nullopt;
  if (ContradictCorrected(known, control)) return std::nullopt;
  const double gsd_m = MedianGsdM(known);
  std::vector<alignment::ControlReport> reports;
  const std::vector<Tied> tied = TiePoints(known, control, reports);
  FlightFacts moved = known;
  GroundSimilarity move;
  if (!tied.empty()) move = FitMove(tied, ExtentM(known));
  if (std::abs(std::abs(move.turn_and_scale) - 1.0) > kMaxStretch ||
      std::abs(std::arg(move.turn_and_scale)) > kMaxTurnRad) {
    return std::nullopt;
  }
  double square_m2 = 0.0;
  for (const Tied& one : tied) {
    const Complex residual = move * one.now - one.surveyed;
    if (std::abs(residual) > kSurveyM + kMaxResidualGsds * gsd_m) return std::nullopt;
    square_m2 += std::norm(residual);
    alignment::ControlReport& told = reports[one.report];
    told.is_used = true;
    told.miss_east_m = residual.real();
    told.miss_north_m = residual.imag();
    told.residual_px = std::abs(residual) / gsd_m;
  }
  Predict(tied, ExtentM(known), reports);
  if (tied.size() > 1) {  // they say where it lies, no longer whoever placed it by hand
    moved.is_by_hand = false;
    Forget(flight::RemarkCode::kControlOverruled, moved.flight.warnings);
    std::erase_if(moved.flight.warnings, IsOfHand);
  }
  const std::vector<flight::Remark> on_points = alignment::RemarksOn(reports);
  moved.flight.warnings.insert(moved.flight.warnings.end(), on_points.begin(), on_points.end());
  const Complex middle =
      EastNorth(known.flight.photos[known.flight.photos.size() / 2].cam_from_enu.TargetOriginInSource());
  const Complex shift = move * middle - middle;
  TellOfControl(reports, {shift.real(), shift.imag(), 0.0}, moved);
  const double max_moved_m = std::abs(shift) + std::abs(move.turn_and_scale - 1.0) * ExtentM(known);
  if (max_moved_m < kNoMoveGsds * gsd_m) return moved;

  MoveFlight(AboutVertical(move, known.ground.MeanHeight()), moved);
  // A single point has nothing to be checked against: the flight is better placed, but no more certain.
  if (tied.size() > 1) {
    const double residual_m = std::max(kSurveyM, std::sqrt(square_m2 / static_cast<double>(tied.size())));
    for (AlignedPhoto& photo : moved.flight.photos) {
      if (photo.placement == alignment::Placement::kAligned) photo.error_radius_m = residual_m;
    }
  }
  moved.flight.warnings.push_back({flight::RemarkCode::kMovedToControl,
                                   {{"points", tied.size()},
                                    {"east_m", shift.real()},
                                    {"north_m", shift.imag()},
                                    {"turn_deg", geo::RadToDeg(std::arg(move.turn_and_scale))},
                                    {"growth_percent", 100.0 * (std::abs(move.turn_and_scale) - 1.0)}}});
  return moved;
}

std::optional<poses::RecordsApart> RecordsApartOf(const FlightFacts& facts) {
  return RecordsApartOfControl({.flight = facts.flight,
                                .poses = facts.poses_report,
                                .alignment = facts.align_report ? &*facts.align_report : nullptr,
                                .is_placed = facts.is_placed});
}

}  // namespace

std::optional<FlightFacts> MoveToControl(const FlightFacts& known,
                                         const std::vector<flight::GcpList>& lists) {
  std::optional<FlightFacts> moved = MovedToControl(known, lists);
  if (!moved) return moved;
  const auto apart = RecordsApartOf(*moved);
  return apart && apart->IsElsewhere() ? std::nullopt : std::move(moved);
}

namespace {

// By name and place: two lists may have points of one name.
using PointKey = std::tuple<std::string, double, double>;

PointKey KeyOf(const alignment::ControlPoint& point) {
  return {point.name, point.position.lat_deg, point.position.lon_deg};
}

PointKey KeyOf(const alignment::ControlReport& point) {
  return {point.name, point.surveyed.lat_deg, point.surveyed.lon_deg};
}

bool IsPlacing(const alignment::ControlReport& point) { return point.is_used && !point.is_check; }

// The survey counts its heights from the sea, the records from the ellipsoid, or from wherever a barometer
// was set to zero: how far the two lie apart, by the points that place the map.
std::optional<double> SurveyAboveRecordsM(const FlightFacts& facts,
                                          const std::vector<alignment::ControlPoint>& control) {
  std::set<PointKey> placing;
  for (const alignment::ControlReport& point : facts.align_report->control) {
    if (IsPlacing(point)) placing.insert(KeyOf(point));
  }
  std::vector<alignment::ControlReport> ignored;
  std::vector<std::optional<double>> surveyed_m;
  std::vector<double> shown_m, above_m;
  for (const MarkedPoint& marked : MarkedPointsOf(facts, control, ignored)) {
    if (!placing.contains(KeyOf(marked.point))) continue;
    surveyed_m.push_back(marked.point.height_m);
    shown_m.push_back(facts.flight.frame.Wgs84FromEnu(marked.seen_in_enu).height_ellipsoid_m);
  }
  const std::vector<std::optional<double>> empty = alignment::HeightsLeftEmpty(surveyed_m, shown_m);
  for (std::size_t k = 0; k < surveyed_m.size(); ++k) {
    if (surveyed_m[k] && !empty[k]) above_m.push_back(*surveyed_m[k] - shown_m[k]);
  }
  return MedianIfAny(std::move(above_m));
}

// Where the finished map has points that did not place it, against where they were surveyed; east and north
// alone, since survey and flight seldom share their zero of heights.
std::vector<alignment::ControlReport> CompareWithSurvey(const FlightFacts& facts,
                                                        const std::vector<alignment::ControlPoint>& checks) {
  std::vector<alignment::ControlReport> reports;
  const double gsd_m = MedianGsdM(facts);
  for (const MarkedPoint& marked : MarkedPointsOf(facts, checks, reports)) {
    const Eigen::Vector3d miss =
        marked.seen_in_enu - facts.flight.frame.EnuAtHeight(marked.point.position, marked.seen_in_enu.z());
    alignment::ControlReport& told = reports[marked.report];
    told.is_used = true;
    told.miss_east_m = miss.x();
    told.miss_north_m = miss.y();
    told.residual_px = gsd_m > 0.0 ? miss.head<2>().norm() / gsd_m : 0.0;
  }
  for (alignment::ControlReport& told : reports) told.is_check = true;
  return reports;
}

std::ptrdiff_t PointsUsed(const alignment::AlignReport& report) {
  return std::count_if(report.control.begin(), report.control.end(), IsPlacing);
}

// Who was moved without figures was moved.
bool IsAnyUsed(const FlightFacts& facts) {
  return !facts.align_report || PointsUsed(*facts.align_report) > 0;
}

// Where no number is stated of the map, or one surveyed point moved it, which states none. A map by its
// positions misses all check points by what these err by: that is its accuracy, and names none.
double CheckedToM(const FlightFacts& facts) {
  if (IsAnyUsed(facts)) return alignment::kNoSurveyM;  // surveyed points place it
  const std::vector<const flight::RecordedPosition*> records = RecordsOf(facts);
  const double common_m = records.empty() ? facts.poses_report.log_position_sigma_m.value_or(0.0)
                                          : poses::CommonErrorOf(records).sigma_m;
  return std::max(alignment::kNoSurveyM, kCheckSigmas * common_m);
}

// Said first, or by what comes next no longer.
void TellOfRecords(FlightFacts& facts) {
  std::vector<flight::Remark>& warnings = facts.flight.warnings;
  Forget(flight::RemarkCode::kControlContradictsRecords, warnings);
  const auto apart = RecordsApartOf(facts);
  if (!apart || !apart->IsContradiction()) return;
  warnings.insert(warnings.begin(),
                  flight::Remark{flight::RemarkCode::kControlContradictsRecords,
                                 {{"apart_m", apart->apart_m.norm()}, {"agreed_m", apart->agreed_m}}});
}

// By the rule that limits the map.
std::vector<std::optional<double>> AllowedM(const FlightFacts& facts) {
  if (PointsUsed(*facts.align_report) == 1)
    return std::vector<std::optional<double>>(facts.align_report->control.size());
  return MissesAllowedM({.flight = facts.flight,
                         .poses = facts.poses_report,
                         .alignment = &*facts.align_report,
                         .photo_gsd_m = MedianGsdM(facts),
                         .is_placed = facts.is_placed,
                         .is_by_images = facts.is_by_images,
                         .is_by_hand = facts.is_by_hand});
}

// Of a map with figures of its alignment.
void TellOfChecks(FlightFacts& facts) {
  std::vector<flight::Remark>& warnings = facts.flight.warnings;
  Forget(flight::RemarkCode::kCheckFarOff, warnings);
  const std::vector<std::optional<double>> allowed_m = AllowedM(facts);
  const double otherwise_m = CheckedToM(facts);
  for (std::size_t k = 0; k < allowed_m.size(); ++k) {
    const alignment::ControlReport& check = facts.align_report->control[k];
    if (!check.is_check) continue;
    const double apart_m = std::hypot(check.miss_east_m, check.miss_north_m);
    if (check.is_used && apart_m > allowed_m[k].value_or(otherwise_m)) {
      warnings.push_back({flight::RemarkCode::kCheckFarOff, {{"point", check.name}, {"apart_m", apart_m}}});
    } else if (!check.is_used && check.reason) {
      flight::Remark unused{flight::RemarkCode::kControlNotUsed,
                            {{"point", check.name}, {"reason", *check.reason}}};
      std::erase(warnings, unused);  // of an earlier run
      warnings.push_back(std::move(unused));
    }
  }
}

// With check points, which leave it where it is: whoever placed it by hand still did.
FlightFacts ComparedAlone(FlightFacts known) {
  std::erase_if(known.flight.warnings, [](const flight::Remark& said) {
    return IsOfControl(said) && said.code != flight::RemarkCode::kControlOverruled;
  });
  TellOfControl({}, Eigen::Vector3d::Zero(), known);
  return known;
}

// Refused where the photos say that the flight was not: points of another place move no finished map.
Result<FlightFacts> NotElsewhere(FlightFacts placed, const std::vector<flight::GcpList>& lists) {
  const auto apart = RecordsApartOf(placed);
  if (!apart || !apart->IsElsewhere()) return placed;
  return flight::Because(ErrorCode::kUnprocessable,
                         {flight::RemarkCode::kControlElsewhere,
                          {{"file", lists.front().file_name}, {"apart_m", apart->apart_m.norm()}}});
}

}  // namespace

Result<FlightFacts> PlaceByLists(FlightFacts known, const std::vector<flight::GcpList>& lists,
                                 bool* contradict) {
  if (ControlPointsOf(lists).empty()) {
    // What placed it may be the same points, which then bear themselves out. Photos that lie by their poses
    // alone show no point where it is.
    const bool is_told = known.is_placed && known.align_report && PointsUsed(*known.align_report) == 0;
    if (is_told && !CheckPointsOf(lists).empty()) return ComparedAlone(std::move(known));
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailNoPointMarked);
  }
  std::erase_if(known.flight.warnings, IsOfControl);
  if (known.is_placed) {
    std::optional<FlightFacts> moved = MovedToControl(known, lists);
    if (moved && IsAnyUsed(*moved)) return NotElsewhere(*std::move(moved), lists);
    if (!moved && AreTwo(known, ControlPointsOf(lists)))
      return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailTwoPoints);
    if (ContradictCorrected(known, ControlPointsOf(lists))) {
      if (contradict != nullptr) *contradict = true;
      return flight::Because(ErrorCode::kUnprocessable, {flight::RemarkCode::kFailPointsContradict,
                                                         {{"apart_m", alignment::kNoSurveyM}}});
    }
  }
  PlaceRequest request;
  request.control = lists;
  request.is_again = true;
  SKYQUILT_TRY_ASSIGN(FlightFacts placed, PlaceKnown(std::move(known), request, contradict));
  return NotElsewhere(std::move(placed), lists);
}

void TellMarks(const std::vector<flight::GcpList>& lists, FlightFacts& facts) {
  if (!facts.is_placed || !facts.align_report) return;
  std::vector<alignment::ControlReport>& told = facts.align_report->control;
  const std::vector<alignment::ControlPoint> checks = CheckPointsOf(lists);
  std::vector<alignment::ControlPoint> all = ControlPointsOf(lists);
  all.insert(all.end(), checks.begin(), checks.end());
  std::map<PointKey, std::vector<alignment::ControlMarkReport>> marks_of;
  std::vector<std::vector<alignment::ControlMarkReport>> residuals = MarkResiduals(facts, all);
  for (std::size_t k = 0; k < all.size(); ++k) marks_of.emplace(KeyOf(all[k]), std::move(residuals[k]));
  const auto is_listed = [&](const alignment::ControlReport& point) {
    return marks_of.contains(KeyOf(point));
  };
  const bool is_by_others = std::any_of(told.begin(), told.end(), [&](const alignment::ControlReport& point) {
    return IsPlacing(point) && !is_listed(point);
  });
  if (!is_by_others) facts.align_report->survey_above_records_m = SurveyAboveRecordsM(facts, all);
  std::erase_if(told, [&](const alignment::ControlReport& point) {
    return point.is_check && (!is_by_others || is_listed(point));
  });
  const std::vector<alignment::ControlReport> compared = CompareWithSurvey(facts, checks);
  told.insert(told.end(), compared.begin(), compared.end());
  TellOfChecks(facts);
  TellOfRecords(facts);
  for (alignment::ControlReport& point : told) {
    const auto found = marks_of.find(KeyOf(point));
    if (found != marks_of.end())
      point.marks = found->second;
    else if (!is_by_others)
      point.marks.clear();
  }
}

}  // namespace skyquilt::pipeline
