#include "core/pipeline/placing/place_known.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/alignment/bundle/control_points.h"
#include "core/base/median.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/bounds.h"
#include "core/geo/lat_lon.h"
#include "core/pipeline/placing/control_points.h"
#include "core/pipeline/placing/move_flight.h"

namespace skyquilt::pipeline {
namespace {

using alignment::AlignedPhoto;
using alignment::FittedSimilarity;
using alignment::PlacePair;
using alignment::Similarity3;
using Eigen::Vector3d;
using flight::Remark;
using flight::RemarkCode;

constexpr double kFinestPixelM = 0.0005, kCoarsestPixelM = 50.0;
constexpr std::size_t kMinPoints = 3;
// Points nearer together than this share of the flight's extent say too little of scale and north.
constexpr double kMinSpread = 0.1;
constexpr double kMinSigmaM = 0.02;
// What points may miss by and still agree: the block bends by some pixels, more the wider it is.
constexpr double kAgreedPixels = 6.0;
constexpr double kAgreedShare = 0.01;  // of the points' spread
// Up as the flight has it: by its own ground or by recorded angles.
constexpr double kSigmaUpRad = 0.05;

Error Refused(ErrorCode code, std::string message) { return Error{code, std::move(message), ""}; }

double TurnDeg(const Similarity3& move) {
  const Vector3d east = move.rotation * Vector3d::UnitX();
  return geo::RadToDeg(std::atan2(east.y(), east.x()));
}

Result<Similarity3> CheckedScale(const FlightFacts& known, Similarity3 move) {
  const double pixel_m = MedianGsdM(known) * move.scale;
  if (pixel_m >= kFinestPixelM && pixel_m <= kCoarsestPixelM) return move;
  return flight::Because(ErrorCode::kInvalidArgument, {RemarkCode::kFailScale,
                                                       {{"pixel_m", pixel_m},
                                                        {"finest_m", kFinestPixelM},
                                                        {"coarsest_m", kCoarsestPixelM},
                                                        {"now_m", MedianGsdM(known)}}});
}

// The place in the flight's frame that the origin is of.
Result<Vector3d> OriginIn(const FlightFacts& known, const PlaceRequest& request) {
  if (!request.origin_photo.empty()) {
    for (const AlignedPhoto& photo : known.flight.photos) {
      if (photo.photo.name == request.origin_photo) return photo.cam_from_enu.TargetOriginInSource();
    }
    return Refused(ErrorCode::kInvalidArgument,
                   fmt::format("The map shows no photo called {}; the first is {}.", request.origin_photo,
                               known.flight.photos.front().photo.name));
  }
  if (!known.is_by_images && !known.is_placed) return Vector3d(Vector3d::Zero());  // the take-off
  geo::Bounds2 bounds;
  for (const AlignedPhoto& photo : known.flight.photos) {
    bounds.Include(photo.cam_from_enu.TargetOriginInSource().head<2>());
  }
  const Eigen::Vector2d middle = 0.5 * (bounds.min + bounds.max);
  return Vector3d(middle.x(), middle.y(), 0.0);
}

Result<FlightFacts> PlaceByOrigin(const FlightFacts& known, const PlaceRequest& request) {
  const double gsd_m = MedianGsdM(known), north_deg = request.north_deg.value_or(0.0);
  Similarity3 move;
  if (request.photo_pixel_m) move.scale = *request.photo_pixel_m / gsd_m;
  if (request.factor) move.scale = *request.factor;
  if (!(move.scale > 0.0) || !std::isfinite(move.scale) || !std::isfinite(north_deg)) {
    return Refused(ErrorCode::kInvalidArgument, "The scale must be above 0, and north a number of degrees.");
  }
  move.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(geo::DegToRad(north_deg), Vector3d::UnitZ()));
  SKYQUILT_TRY_ASSIGN(const Vector3d origin, OriginIn(known, request));
  const double ground_z_m = known.ground.MeanHeight();
  move.shift = -(move.scale * (move.rotation * Vector3d(origin.x(), origin.y(), ground_z_m)));
  move.shift.z() += ground_z_m;  // the ground keeps its height
  SKYQUILT_TRY_ASSIGN(move, CheckedScale(known, move));
  FlightFacts placed = known;
  MoveFlight(move, placed);
  placed.flight.frame = geo::LocalFrame(
      {request.origin->lat_deg, request.origin->lon_deg, known.flight.frame.origin().height_ellipsoid_m});
  Remark said{RemarkCode::kPlacedByOrigin,
              {{"lat_deg", request.origin->lat_deg},
               {"lon_deg", request.origin->lon_deg},
               {"turn_deg", TurnDeg(move)},
               {"times", move.scale}}};
  if (!request.origin_photo.empty()) {
    said.code = RemarkCode::kPlacedByPhoto;
    said.values.emplace("photo", request.origin_photo);
  }
  placed.flight.warnings.push_back(std::move(said));
  return placed;
}

Result<FlightFacts> PlaceByPairs(const FlightFacts& known, const std::vector<ShownPair>& pairs) {
  SKYQUILT_TRY_ASSIGN(MoveOfPairs move, MoveByPairs(known, pairs));
  SKYQUILT_TRY_ASSIGN(move.new_from_old, CheckedScale(known, move.new_from_old));
  FlightFacts placed = known;
  MoveFlight(move.new_from_old, placed);
  placed.flight.frame = move.frame;
  Remark said{RemarkCode::kPlacedByPairs,
              {{"points", pairs.size()},
               {"turn_deg", TurnDeg(move.new_from_old)},
               {"times", move.new_from_old.scale}}};
  if (pairs.size() > 2) {
    Remark apart{RemarkCode::kPairsDisagree, {{"apart_m", move.miss_m}}};
    said = {RemarkCode::kSentences, {{"first", std::move(said)}, {"then", std::move(apart)}}};
  }
  placed.flight.warnings.push_back(std::move(said));
  return placed;
}

geo::LocalFrame FrameOf(const std::vector<MarkedPoint>& marked) {
  std::vector<double> lats, lons, heights;
  for (const MarkedPoint& one : marked) {
    lats.push_back(one.point.position.lat_deg);
    lons.push_back(one.point.position.lon_deg);
    if (one.point.height_m) heights.push_back(*one.point.height_m);
  }
  return geo::LocalFrame(
      {Median(std::move(lats)), Median(std::move(lons)), MedianIfAny(std::move(heights)).value_or(0.0)});
}

std::vector<PlacePair> PairsOf(const std::vector<MarkedPoint>& marked, const geo::LocalFrame& frame) {
  std::vector<PlacePair> pairs;
  for (const MarkedPoint& one : marked) {
    PlacePair pair;
    pair.in_source = one.seen_in_enu;
    pair.in_target = frame.EnuFromWgs84({one.point.position.lat_deg, one.point.position.lon_deg,
                                         one.point.height_m.value_or(frame.origin().height_ellipsoid_m)});
    pair.sigma = {one.point.sigma_horizontal_m, one.point.sigma_horizontal_m,
                  one.point.height_m ? one.point.sigma_vertical_m : std::numeric_limits<double>::infinity()};
    pairs.push_back(pair);
  }
  return pairs;
}

// Each point that is used, by a fit to the others that are.
void PredictPairs(const std::vector<PlacePair>& pairs, const std::vector<MarkedPoint>& marked,
                  std::vector<alignment::ControlReport>& reports) {
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (reports[marked[k].report].is_used) used.push_back(k);
  }
  if (used.size() < alignment::kMinPredictedPoints) return;
  for (const std::size_t left : used) {
    std::vector<PlacePair> others;
    for (const std::size_t k : used) {
      if (k != left) others.push_back(pairs[k]);
    }
    const auto fitted =
        alignment::FitRobustly(others, alignment::UpDirection{Vector3d::UnitZ(), kSigmaUpRad});
    if (!fitted) continue;
    const Vector3d miss = fitted->target_from_source * pairs[left].in_source - pairs[left].in_target;
    const bool has_height = std::isfinite(pairs[left].sigma.z());
    reports[marked[left].report].left_out =
        alignment::ControlPrediction{miss.x(), miss.y(), has_height ? miss.z() : alignment::kNotComparedM};
  }
}

double SpreadM(const std::vector<MarkedPoint>& marked) {
  geo::Bounds2 bounds;
  for (const MarkedPoint& one : marked) bounds.Include(one.seen_in_enu.head<2>());
  return std::hypot(bounds.Width(), bounds.Height());
}

// `why`, and what is wrong with the first points of which it is known.
Error RefusedPoints(Remark why, const std::vector<alignment::ControlReport>& reports) {
  constexpr std::size_t kMaxNamed = 5;
  std::vector<Remark> all{std::move(why)};
  for (const alignment::ControlReport& report : reports) {
    if (report.reason && all.size() <= kMaxNamed)
      all.push_back({RemarkCode::kControlNoted, {{"point", report.name}, {"reason", *report.reason}}});
  }
  return flight::Because(ErrorCode::kUnprocessable, flight::InARow(std::move(all)));
}

Result<FlightFacts> PlaceByControl(const FlightFacts& known, const std::vector<flight::GcpList>& lists,
                                   bool* contradict) {
  std::vector<alignment::ControlReport> reports;
  const std::vector<MarkedPoint> marked = MarkedPointsOf(known, ControlPointsOf(lists), reports);
  if (marked.size() < kMinPoints) {
    return RefusedPoints({RemarkCode::kFailFewPoints,
                          {{"points", reports.size()}, {"used", marked.size()}, {"needed", kMinPoints}}},
                         reports);
  }
  const double spread_m = SpreadM(marked);
  if (spread_m < kMinSpread * ExtentM(known)) {
    return flight::Because(
        ErrorCode::kUnprocessable,
        {RemarkCode::kFailPointsTooNear, {{"share_percent", 100.0 * spread_m / ExtentM(known)}}});
  }
  const geo::LocalFrame frame = FrameOf(marked);
  const std::vector<PlacePair> pairs = PairsOf(marked, frame);
  const std::optional<FittedSimilarity> fitted =
      alignment::FitRobustly(pairs, alignment::UpDirection{Vector3d::UnitZ(), kSigmaUpRad});
  const double scale = fitted ? fitted->target_from_source.scale : 1.0;
  const double agreed_m =
      kMinSigmaM + kAgreedPixels * scale * MedianGsdM(known) + kAgreedShare * scale * spread_m;
  std::vector<double> misses_m;
  FlightFacts placed = known;
  for (std::size_t k = 0; fitted && k < pairs.size(); ++k) {
    const Vector3d miss = fitted->target_from_source * pairs[k].in_source - pairs[k].in_target;
    alignment::ControlReport& told = reports[marked[k].report];
    told.miss_east_m = miss.x();
    told.miss_north_m = miss.y();
    told.miss_up_m = std::isfinite(pairs[k].sigma.z()) ? miss.z() : alignment::kNotComparedM;
    told.residual_px = miss.head<2>().norm() / (scale * MedianGsdM(known));
    told.is_used = fitted->holds[k] && miss.head<2>().norm() <= agreed_m;
    if (told.is_used) {
      misses_m.push_back(miss.head<2>().norm());
    } else {
      told.reason = {RemarkCode::kPointOffOthers, {{"apart_m", miss.head<2>().norm()}}};
    }
  }
  // Three of a line fit many a wrong turn: the points that are refused must be few.
  if (misses_m.size() < kMinPoints || misses_m.size() < 2 * (marked.size() - misses_m.size())) {
    if (contradict != nullptr) *contradict = true;
    return RefusedPoints({RemarkCode::kFailPointsContradict, {{"apart_m", agreed_m}}}, reports);
  }
  PredictPairs(pairs, marked, reports);
  Similarity3 move = fitted->target_from_source;
  const bool has_heights = std::any_of(pairs.begin(), pairs.end(),
                                       [](const PlacePair& pair) { return std::isfinite(pair.sigma.z()); });
  if (!has_heights)
    move.shift.z() += known.ground.MeanHeight() - (move * Vector3d(0.0, 0.0, known.ground.MeanHeight())).z();
  SKYQUILT_TRY_ASSIGN(move, CheckedScale(known, move));
  MoveFlight(move, placed);
  placed.flight.frame = frame;
  const std::vector<Remark> on_points = alignment::RemarksOn(reports);
  placed.flight.warnings.insert(placed.flight.warnings.end(), on_points.begin(), on_points.end());
  const double miss_m = Median(misses_m);
  for (AlignedPhoto& photo : placed.flight.photos) {
    if (photo.placement == alignment::Placement::kAligned)
      photo.error_radius_m = std::max(kMinSigmaM, miss_m);
  }
  const std::size_t middle = known.flight.photos.size() / 2;
  const Vector3d was = known.flight.photos[middle].cam_from_enu.TargetOriginInSource();
  const geo::Wgs84 now = frame.Wgs84FromEnu(placed.flight.photos[middle].cam_from_enu.TargetOriginInSource());
  const Vector3d moved_m = known.flight.frame.EnuFromWgs84(now) - was;
  TellOfControl(reports, {moved_m.x(), moved_m.y(), 0.0}, placed);
  placed.flight.warnings.push_back({RemarkCode::kPlacedByControl,
                                    {{"points", misses_m.size()},
                                     {"apart_m", miss_m},
                                     {"turn_deg", TurnDeg(move)},
                                     {"times", move.scale}}});
  return placed;
}

// Somebody said where the map lies: the survey that placed it before does so no longer.
void OverruleControl(FlightFacts& placed) {
  if (!placed.align_report) return;
  std::vector<alignment::ControlReport>& control = placed.align_report->control;
  const auto placing =
      std::count_if(control.begin(), control.end(),
                    [](const alignment::ControlReport& point) { return point.is_used && !point.is_check; });
  if (placing == 0) return;
  control.clear();
  std::vector<Remark>& warnings = placed.flight.warnings;
  std::erase_if(warnings, IsOfControl);
  warnings.insert(warnings.begin(), Remark{RemarkCode::kControlOverruled, {{"points", placing}}});
}

// One place says neither.
bool AreSeveralPlaces(const PlaceRequest& request) {
  return !request.control.empty() || request.pairs.size() > 1;
}
bool SaysScale(const PlaceRequest& request) {
  return AreSeveralPlaces(request) || request.photo_pixel_m || request.factor;
}
bool SaysNorth(const PlaceRequest& request) { return AreSeveralPlaces(request) || request.north_deg; }

// `flight` is where somebody said, whatever its records say.
void TellPlaced(FlightFacts& flight) {
  flight.is_placed = flight.poses_report.is_placed = true;
  std::erase_if(flight.flight.warnings, [](const Remark& said) {
    return said.code == RemarkCode::kNotGeoreferenced || said.code == RemarkCode::kReckonedFromNowhere;
  });
}

}  // namespace

Result<FlightFacts> PlaceKnown(FlightFacts known, const PlaceRequest& request, bool* contradict) {
  if (known.is_placed && !request.is_again && request.pairs.empty()) {
    return Refused(
        ErrorCode::kConflict,
        "The map is georeferenced already. Say --again to place it anew, over what its records said.");
  }
  if (int{request.origin.has_value()} + int{!request.control.empty()} + int{!request.pairs.empty()} != 1) {
    return Refused(
        ErrorCode::kInvalidArgument,
        "Give a place (--origin), surveyed points (--gcp) or places on the map (--point), and one of them "
        "only.");
  }
  if (known.flight.photos.empty()) {
    return Refused(ErrorCode::kUnprocessable, "The map shows no photo, so there is nothing to place.");
  }
  std::erase_if(known.flight.warnings, [&](const Remark& said) {
    return IsOfHand(said) || (!request.control.empty() && IsOfControl(said));
  });
  SKYQUILT_TRY_ASSIGN(FlightFacts placed, request.origin ? PlaceByOrigin(known, request)
                                          : !request.pairs.empty()
                                              ? PlaceByPairs(known, request.pairs)
                                              : PlaceByControl(known, request.control, contradict));
  placed.is_by_hand = request.control.empty();
  if (placed.is_by_hand) OverruleControl(placed);
  if (SaysScale(request)) placed.poses_report.is_height_guessed.reset();
  if (placed.align_report) {
    alignment::ByImagesReport& by_images = placed.align_report->by_images;
    if (SaysScale(request)) by_images.is_scale_guessed.reset();
    if (SaysNorth(request)) by_images.is_north_guessed.reset();
  }
  TellPlaced(placed);
  return placed;
}

bool KeepPlaceByHand(const FlightFacts& placed_by_hand, FlightFacts& anew) {
  std::map<std::string, Vector3d> centers;
  for (const AlignedPhoto& photo : placed_by_hand.flight.photos)
    centers.emplace(photo.photo.name, photo.cam_from_enu.TargetOriginInSource());
  std::vector<PlacePair> pairs;
  for (const AlignedPhoto& photo : anew.flight.photos) {
    const auto before = centers.find(photo.photo.name);
    if (before == centers.end()) continue;
    pairs.push_back({.in_source = photo.cam_from_enu.TargetOriginInSource(), .in_target = before->second});
  }
  const auto fitted = alignment::FitRobustly(
      pairs, alignment::UpDirection{.in_source = Vector3d::UnitZ(), .sigma_rad = kSigmaUpRad});
  if (!fitted) return false;
  MoveFlight(fitted->target_from_source, anew);
  anew.flight.frame = placed_by_hand.flight.frame;
  anew.is_by_hand = true;
  // Scale and north are those of before, a guess or not.
  anew.poses_report.is_height_guessed = placed_by_hand.poses_report.is_height_guessed;
  if (anew.align_report) {
    const alignment::ByImagesReport before =
        placed_by_hand.align_report ? placed_by_hand.align_report->by_images : alignment::ByImagesReport();
    anew.align_report->by_images.is_scale_guessed = before.is_scale_guessed;
    anew.align_report->by_images.is_north_guessed = before.is_north_guessed;
  }
  for (const Remark& said : placed_by_hand.flight.warnings) {
    if (IsOfHand(said)) anew.flight.warnings.push_back(said);
  }
  TellPlaced(anew);
  return true;
}

}  // namespace skyquilt::pipeline
