#include "core/poses/estimate_poses.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "core/base/median.h"
#include "core/base/try.h"
#include "core/flight/aside/aside.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/geodesic.h"
#include "core/geo/geoid.h"
#include "core/poses/conventions/choose_convention.h"
#include "core/poses/evidence/common_error.h"
#include "core/poses/evidence/repeated_positions.h"
#include "core/poses/heights/flight_heights.h"
#include "core/poses/heights/ground_below.h"
#include "core/poses/heights/takeoff.h"
#include "core/poses/keep_positions.h"
#include "core/poses/lists/list_words.h"
#include "core/poses/lists/one_frame.h"
#include "core/poses/photo_rows.h"
#include "core/poses/place_by_log.h"
#include "core/poses/place_by_records.h"
#include "core/poses/plausible_poses.h"
#include "core/poses/time/join_logs.h"
#include "core/poses/time/tie_to_log.h"

namespace skyquilt::poses {
namespace {

using flight::LeftOutPhoto;
using flight::Photo;
using flight::Remark;
using flight::RemarkCode;

template <typename From, typename To>
void Append(std::vector<From> more, std::vector<To>& all) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

ConventionChoice ChooseReading(const flight::FlightLog* log, LogTie& tie) {
  std::vector<std::optional<double>> airframe_yaw(tie.photos.size());
  for (const TiedPhoto& p : tie.tied) airframe_yaw[p.photo] = AirframeYawAt(*log, p.t_s);
  return ChooseConvention(tie.photos, airframe_yaw);
}

void DescribeTime(const TimeSync& sync, PoseReport& report) {
  report.time_match = sync.method_in_words;
  for (const std::string& note : sync.notes) report.time_match += "; " + note;
  report.time_offset_s = sync.offset_s;
  report.time_sigma_s = sync.sigma_s;
  report.camera_ahead_of_utc_s = sync.camera_ahead_of_utc_s;
}

// What the user says of the take-off. It is near any place of the flight as far as the geoid goes.
std::optional<double> GivenTakeoffM(const EstimatePosesOptions& options, const std::vector<Photo>& photos,
                                    const std::optional<JoinedLog>& log) {
  if (!options.takeoff_height_amsl_m) return std::nullopt;
  std::vector<geo::LatLon> positions;
  if (log && !log->log.gnss.empty()) positions.push_back(log->log.gnss.front().position);
  for (const Photo& photo : photos) {
    if (positions.empty() && photo.position) positions.push_back(photo.position->position);
  }
  if (positions.empty() && options.origin) positions.push_back(*options.origin);
  const double geoid_m = positions.empty() ? 0.0 : geo::GeoidHeightM(positions.front()).value_or(0.0);
  return *options.takeoff_height_amsl_m + geoid_m;
}

// By which of its positions a photo stands; its own ones, and those of lists, are another witness.
std::optional<double> ApartFromRecordsM(const PosedFlight& by_log) {
  std::vector<double> apart_m;
  for (const PosedPhoto& photo : by_log.photos) {
    if (!photo.photo.position || photo.position_source.empty() ||
        photo.photo.position->source.starts_with(photo.position_source))
      continue;
    const geo::Wgs84 at = by_log.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    apart_m.push_back(geo::MetresApart({at.lat_deg, at.lon_deg}, photo.photo.position->position));
  }
  return MedianIfAny(std::move(apart_m));
}

// What came of the log that leads, for its line. `by_log`: the photos on its series, before others are added.
void DescribeUse(const flight::FlightLog& log, const LogTie& tie, const PosedFlight& by_log, bool gives_way,
                 PoseReport& report) {
  const auto by_events = std::count_if(tie.photos.begin(), tie.photos.end(), [&](const Photo& photo) {
    return photo.position && photo.position->source.starts_with(log.file_name);
  });
  std::string use = gives_way ? "its track gives way to the corrected positions" : "";
  if (!by_log.photos.empty()) {
    use += fmt::format("{}{} of {} photos placed by its series", use.empty() ? "" : "; ",
                       by_log.photos.size(), tie.photos.size());
    if (const auto apart_m = ApartFromRecordsM(by_log))
      use += fmt::format(", {} from the photos' own positions", flight::LengthInWords(*apart_m));
  }
  if (by_events > 0) {
    use += fmt::format("{}{} of {} photos stand where its camera events say", use.empty() ? "" : "; ",
                       by_events, tie.photos.size());
  }
  if (use.empty()) use = "no photo is placed by it";
  const std::string name = fmt::format("{} ({})", log.file_name, log.format);
  const auto line = std::find(report.logs.begin(), report.logs.end(), name);
  if (line == report.logs.end())
    report.logs.push_back(name + ": " + use);
  else
    *line += ": " + use;
}

// Whoever gives one may mean that the map is to lie there.
void TellUnusedOrigin(const EstimatePosesOptions& options, PosedFlight& posed) {
  const bool is_used = std::find(posed.warnings.begin(), posed.warnings.end(),
                                 Remark(RemarkCode::kReckonedFromOrigin)) != posed.warnings.end();
  if (options.origin && !is_used) posed.warnings.push_back(RemarkCode::kOriginNotUsed);
}

void TakeLogged(Takeoff takeoff, PlacedByLog placed, bool has_origin, PosedFlight& posed) {
  PoseReport& report = posed.report;
  posed.ground_z_in_enu_m = takeoff.ground_above_takeoff_m;
  posed.hangs_on_cameras = takeoff.hangs_on_cameras;
  posed.is_placed = placed.is_placed || has_origin;
  posed.photos = std::move(placed.photos);
  report.height_rule = takeoff.rule;
  report.heights_above_ellipsoid = takeoff.is_above_ellipsoid;
  report.series = std::move(placed.series);
  report.knots = placed.smoothing.knots;
  report.iterations = placed.smoothing.iterations;
  report.photos_by_log = static_cast<int>(posed.photos.size());
  report.method = "smoothed track of the log";
  Append(std::move(placed.smoothing.warnings), posed.warnings);
  if (takeoff.assumption) {
    posed.assumptions.push_back(*std::move(takeoff.assumption));
    report.is_height_guessed = true;
  }
  if (placed.is_placed) return;
  report.method = "reckoned from the start without any position";
  posed.warnings.push_back(has_origin ? RemarkCode::kReckonedFromOrigin : RemarkCode::kReckonedFromNowhere);
}

// The photos that the log covers, in the frame that its take-off sets; where that is, if anywhere.
Result<std::optional<geo::LatLon>> PlaceLogged(const flight::FlightLog& log, const LogTie& tie,
                                               const EstimatePosesOptions& options,
                                               const std::optional<double>& given_takeoff_m,
                                               bool keeps_positions, PosedFlight& posed) {
  FlightSources sources;
  sources.log = &log;
  sources.photo_clock_sigma_s = tie.clock_sigma_s;
  sources.ended_at_start = options.landed_at_start;
  for (const TiedPhoto& p : tie.tied) {
    PhotoAtTime& at = sources.photos.emplace_back();
    at.photo = &tie.photos[p.photo];
    at.t_s = p.t_s;
    at.sigma_s = p.sigma_s;
    if (at.photo->position) at.height_above_ground_m = at.photo->position->height_above_takeoff_m;
  }
  Takeoff takeoff = FindTakeoff(log, sources.photos, given_takeoff_m);
  const geo::LatLon middle = takeoff.middle.value_or(options.origin.value_or(geo::LatLon{}));
  const geo::LocalFrame frame({middle.lat_deg, middle.lon_deg, takeoff.height_ellipsoid_m});
  SKYQUILT_TRY_ASSIGN(PlacedByLog placed, PlaceByLog(sources, frame, takeoff.ground_above_takeoff_m));
  // The log's heights agree with each other; where they all hang is what was given.
  double takeoff_m = given_takeoff_m.value_or(takeoff.height_ellipsoid_m);
  if (given_takeoff_m) takeoff.hangs_on_cameras = false;
  if (given_takeoff_m || keeps_positions) takeoff.is_above_ellipsoid = true;
  if (keeps_positions) {  // z = 0 lies at the heights of these, not at a plain receiver's
    std::vector<Photo> photos = tie.photos;
    std::erase_if(photos, [](const Photo& photo) { return !photo.position; });
    takeoff_m = ChooseHeights(photos, options.dem, given_takeoff_m).takeoff_ellipsoid_m;
  }
  posed.frame = geo::LocalFrame({middle.lat_deg, middle.lon_deg, takeoff_m});
  if (!log.gnss.empty()) {
    const CommonError common = CommonErrorOf(log.gnss);
    posed.report.log_position_sigma_m = common.sigma_m;
    posed.report.log_is_corrected = common.is_corrected;
  }
  const std::optional<geo::LatLon> position = takeoff.position ? takeoff.position : options.origin;
  TakeLogged(std::move(takeoff), std::move(placed), options.origin.has_value(), posed);
  return position;
}

// Photos outside the log, or all of them without one. The frame is theirs where no log has set it.
PlacedByRecords PlaceRest(const std::vector<Photo>& rest, const FlightHeights& heights, bool has_frame,
                          PosedFlight& posed) {
  PoseReport& report = posed.report;
  if (heights.assumption) {
    posed.assumptions.push_back(*heights.assumption);
    if (!has_frame) report.is_height_guessed = true;
  }
  if (report.height_rule.empty()) report.height_rule = heights.rule_in_words;
  if (!has_frame) {
    std::vector<geo::LatLon> positions;
    positions.reserve(rest.size());
    for (const Photo& photo : rest) positions.push_back(photo.position->position);
    const geo::LatLon middle = *MedianPosition(positions);
    posed.frame = geo::LocalFrame({middle.lat_deg, middle.lon_deg, heights.takeoff_ellipsoid_m});
    posed.hangs_on_cameras = heights.hangs_on_cameras;
    report.heights_above_ellipsoid = heights.is_above_ellipsoid;
  }
  PlacedByRecords placed = PlaceByRecords(rest, heights, posed.frame);
  if (placed.without_angles > 0) {
    Remark assumed = RemarkCode::kAnglesAssumed;
    if (placed.by_direction > 0)
      assumed = {RemarkCode::kAnglesAssumedByDirection, {{"photos", placed.by_direction}}};
    posed.assumptions.push_back(
        {{RemarkCode::kNoAngles, {{"photos", placed.without_angles}, {"total", placed.photos.size()}}},
         std::move(assumed),
         std::nullopt});
  }
  report.photos_by_records = static_cast<int>(placed.photos.size());
  if (report.method.empty()) report.method = "what the photos record of themselves";
  return placed;
}

Error NothingPlaced(const flight::Flight& flight, bool has_log_and_photos, bool any_without_height,
                    const PosedFlight& posed) {
  const std::vector<LeftOutPhoto>& aside = flight.left_out;  // before any was placed
  if (flight.photos.empty() && !aside.empty()) {
    return flight::Because(
        ErrorCode::kUnprocessable,
        {RemarkCode::kFailNoPhotos, {{"files", aside.size()}, {"left", flight::FirstLeftOut(aside)}}});
  }
  std::vector<Remark> why;
  if (any_without_height) {
    const auto first = posed.left_out.begin() + static_cast<std::ptrdiff_t>(aside.size());
    why.push_back({RemarkCode::kFailNoHeights, {{"left", FirstImplausible({first, posed.left_out.end()})}}});
  } else if (!has_log_and_photos) {
    why.push_back(RemarkCode::kFailNoPositions);
  } else {
    why.push_back(RemarkCode::kFailNoneTied);
    why.insert(why.end(), posed.warnings.begin(), posed.warnings.end());
  }
  if (!aside.empty()) {
    why.push_back(
        {RemarkCode::kFailOthersAside, {{"pictures", aside.size()}, {"left", flight::FirstLeftOut(aside)}}});
  }
  return flight::Because(ErrorCode::kUnprocessable, flight::InARow(std::move(why)));
}

// A flight that no record places: a frame for what its photos may say.
void LeaveUnplaced(const flight::Flight& flight, const EstimatePosesOptions& options,
                   const std::optional<double>& given_takeoff_m, PosedFlight& posed) {
  std::vector<geo::LatLon> positions;
  std::vector<double> heights;
  for (const flight::GcpList& list : flight.gcp_lists) {
    for (const flight::GcpPoint& point : list.points) {
      positions.push_back(point.position);
      if (point.height_m) heights.push_back(*point.height_m);
    }
  }
  for (const Photo& photo : posed.unplaced) {
    if (positions.empty() && photo.position) positions.push_back(photo.position->position);
  }
  const geo::LatLon middle = MedianPosition(positions).value_or(options.origin.value_or(geo::LatLon{}));
  const double height_m = MedianIfAny(std::move(heights)).value_or(given_takeoff_m.value_or(0.0));
  posed.frame = geo::LocalFrame({middle.lat_deg, middle.lon_deg, height_m});
  posed.is_placed = posed.report.is_placed = false;
  posed.report.method = "none: no photo records where it was taken";
}

// By name the one after each; of the last one nothing.
std::map<std::string, std::string> NextOfEach(const std::vector<PosedPhoto>& photos) {
  std::map<std::string, std::string> next_of;
  for (std::size_t i = 0; i < photos.size(); ++i)
    next_of.emplace(photos[i].photo.name, i + 1 < photos.size() ? photos[i + 1].photo.name : std::string());
  return next_of;
}

// What a photo shared with the next one goes where that is another now.
void ForgetOtherNexts(const std::map<std::string, std::string>& next_of, std::vector<PosedPhoto>& photos) {
  const std::map<std::string, std::string> next_now = NextOfEach(photos);
  for (PosedPhoto& photo : photos) {
    if (next_of.at(photo.photo.name) != next_now.at(photo.photo.name)) photo.covariance_with_next.setZero();
  }
}

// Photos beside a log come before, between and after those on it.
void SortByCapture(std::vector<PosedPhoto>& photos) {
  const std::map<std::string, std::string> next_of = NextOfEach(photos);
  std::stable_sort(photos.begin(), photos.end(), [](const PosedPhoto& a, const PosedPhoto& b) {
    return flight::ComesBefore(a.photo, b.photo);
  });
  ForgetOtherNexts(next_of, photos);
}

// What no map can be drawn with goes, and what the last photo before it shared with it. `keep_unplaced`: what
// such photos show may place them all the same.
void FilterOutliers(bool keep_unplaced, PosedFlight& posed) {
  const std::map<std::string, std::string> next_of = NextOfEach(posed.photos);
  std::map<std::string, Photo> all;
  if (keep_unplaced) {
    for (const PosedPhoto& photo : posed.photos) all.emplace(photo.photo.name, photo.photo);
  }
  const std::size_t known = posed.left_out.size();
  const std::size_t gone = LeaveOutImplausible(
      posed.frame,
      [](const PosedPhoto& photo) {
        return CameraStand{photo.photo.intrinsics, photo.cam_from_enu, photo.height_above_ground_m};
      },
      posed.photos, posed.left_out);
  if (gone == 0) return;
  for (std::size_t i = known; i < posed.left_out.size() && keep_unplaced; ++i) {
    Photo& photo = all.at(posed.left_out[i].name);
    // No picture brings a flight back from where web maps end.
    if (photo.position && std::abs(photo.position->position.lat_deg) > kHighestLatDeg) continue;
    posed.unplaced.push_back(std::move(photo));
  }
  ForgetOtherNexts(next_of, posed.photos);
}

}  // namespace

Result<PosedFlight> EstimatePoses(const flight::Flight& flight, const EstimatePosesOptions& options) {
  PosedFlight posed;
  posed.left_out = flight.left_out;
  LogTie tie;
  tie.photos = flight.photos;
  PhotoRowsUse rows = ApplyPhotoRows(flight.logs, tie.photos);
  posed.report.logs = std::move(rows.lines);
  for (const flight::ListUse& use : flight.list_uses) posed.report.logs.push_back(UseInWords(use));
  posed.warnings = std::move(rows.warnings);
  Append(WarnOfEmptyLogs(flight.logs), posed.warnings);
  if (options.dem != nullptr && !flight.elevation_models.empty()) {
    posed.report.logs.push_back(flight.elevation_models.front() + ": heights of the ground");
  }
  const std::optional<JoinedLog> log = JoinLogs(flight.logs, tie.photos);
  if (log) {
    Append(log->notes, posed.report.logs);
    Append(log->warnings, posed.warnings);
    tie = TieToLog(log->log, std::move(tie.photos));
    Append(tie.warnings, posed.warnings);
    if (tie.sync) DescribeTime(*tie.sync, posed.report);
  }
  OneFrame one_frame = BringIntoOneFrame(flight.photos, tie.photos);
  posed.report.lists_contradict_m = one_frame.contradict_m;
  Append(std::move(one_frame.warnings), posed.warnings);
  const bool keeps_positions = log && AreSurveyedBesideTrack(log->log, tie);
  if (keeps_positions) KeepPositions(log->log, tie);
  // The track of a log places its photos whatever they repeat.
  const bool has_track = log && !log->log.gnss.empty();
  const auto move_repeated = [&posed](std::vector<Photo>& photos) {
    if (auto remark = MoveRepeatedPositions(photos)) posed.warnings.push_back(*std::move(remark));
  };
  if (!has_track) move_repeated(tie.photos);
  const ConventionChoice reading = ChooseReading(log ? &log->log : nullptr, tie);
  posed.report.convention = reading.words;
  if (reading.is_changed)
    posed.warnings.push_back({RemarkCode::kAnglesReadOtherwise, {{"reading_words", reading.words}}});

  const std::optional<double> given_takeoff_m = GivenTakeoffM(options, tie.photos, log);
  std::optional<geo::LatLon> takeoff;
  // Where the log begins, whatever its track is then used for.
  if (keeps_positions) takeoff = log->log.gnss.front().position;
  std::vector<char> is_on_log(tie.photos.size(), 0);
  if (!tie.tied.empty()) {
    const auto logged = PlaceLogged(log->log, tie, options, given_takeoff_m, keeps_positions, posed);
    if (logged) {
      for (const TiedPhoto& p : tie.tied) is_on_log[p.photo] = 1;
      takeoff = *logged;
    } else {
      posed.warnings.push_back({RemarkCode::kLogUnusable, {{"why", flight::WhyOf(logged.error())}}});
    }
  }

  if (log && !tie.photos.empty()) DescribeUse(log->log, tie, posed, keeps_positions, posed.report);

  std::vector<Photo> rest;
  for (std::size_t i = 0; i < tie.photos.size(); ++i) {
    const Photo& photo = tie.photos[i];
    if (is_on_log[i]) continue;
    if (photo.position) {
      rest.push_back(photo);
    } else {
      posed.left_out.push_back({photo.name, ErrorCode::kNoPosition,
                                log ? RemarkCode::kLeftOutsideLog : RemarkCode::kLeftWithoutPosition});
      if (options.keep_unplaced) posed.unplaced.push_back(photo);
    }
  }
  if (has_track) move_repeated(rest);
  const bool has_frame = !posed.photos.empty();
  DemZero dem_zero = DemZero::kTakeoff;
  bool any_without_height = false;
  if (!rest.empty()) {
    std::optional<double> zero_m = given_takeoff_m;
    if (has_frame && !keeps_positions && !zero_m && posed.report.heights_above_ellipsoid.value_or(false))
      zero_m = posed.frame.origin().height_ellipsoid_m;  // the log's
    const FlightHeights heights = ChooseHeights(rest, options.dem, zero_m);
    if (!has_frame && heights.rule == HeightRule::kElevationModel) dem_zero = DemZero::kSeaLevel;
    PlacedByRecords placed = PlaceRest(rest, heights, has_frame, posed);
    any_without_height = placed.any_without_height;
    if (options.keep_unplaced) Append(std::move(placed.unplaced), posed.unplaced);
    Append(std::move(placed.photos), posed.photos);
    if (has_frame) SortByCapture(posed.photos);
    Append(std::move(placed.left_out), posed.left_out);
  }
  const bool is_any_placed = !posed.photos.empty();
  const std::size_t before = posed.left_out.size();
  if (is_any_placed) {
    if (given_takeoff_m) {
      dem_zero = DemZero::kSeaLevel;
      posed.report.height_rule +=
          fmt::format("; take-off {:.1f} m above sea level, as given", *options.takeoff_height_amsl_m);
    }
    if (options.dem != nullptr && posed.is_placed) PutGroundByDem(*options.dem, takeoff, dem_zero, posed);
    PutGroundBelow(posed);
    FilterOutliers(options.keep_unplaced, posed);
    TellGapsOfDem(posed);
  }
  if (posed.photos.empty() && posed.unplaced.empty()) {
    if (!is_any_placed) return NothingPlaced(flight, log && !tie.photos.empty(), any_without_height, posed);
    const auto first = posed.left_out.begin() + static_cast<std::ptrdiff_t>(before);
    return flight::Because(
        ErrorCode::kUnprocessable,
        {RemarkCode::kFailNoneWhereRecorded, {{"left", FirstImplausible({first, posed.left_out.end()})}}});
  }
  posed.warnings.insert(posed.warnings.begin(), flight.warnings.begin(), flight.warnings.end());
  if (posed.photos.empty()) {
    LeaveUnplaced(flight, options, given_takeoff_m, posed);
    return posed;
  }
  TellUnusedOrigin(options, posed);
  const geo::Wgs84& origin = posed.frame.origin();
  const bool is_by_log = log && posed.report.photos_by_log > 0;
  TellLackOfGeoid(geo::GeoidHeightM({origin.lat_deg, origin.lon_deg}), tie.photos,
                  is_by_log ? &log->log : nullptr, dem_zero == DemZero::kSeaLevel, posed);
  posed.report.is_placed = posed.is_placed;
  std::sort(posed.left_out.begin(), posed.left_out.end(),
            [](const LeftOutPhoto& a, const LeftOutPhoto& b) { return a.name < b.name; });
  return posed;
}

}  // namespace skyquilt::poses
