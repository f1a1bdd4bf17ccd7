#include "core/pipeline/report/mosaic_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/base/text/json_io.h"
#include "core/flight/bytes/written_time.h"
#include "core/flight/remarks/remark_json.h"
#include "core/geo/lat_lon.h"
#include "core/ground/footprint_on_ground.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/judge_map.h"
#include "core/pipeline/report/report_codec.h"
#include "core/poses/conventions/attitude_convention.h"

namespace skyquilt::pipeline {
namespace {

std::string Written(flight::UtcTime time, bool is_local, std::optional<std::chrono::minutes> zone) {
  if (is_local) return flight::WrittenSecond(time);
  if (!zone) return flight::WrittenSecond(time) + "Z";
  const long minutes = std::labs(zone->count());
  return fmt::format("{}{}{:02}:{:02}", flight::WrittenSecond(time + *zone), zone->count() < 0 ? '-' : '+',
                     minutes / 60, minutes % 60);
}

}  // namespace

std::optional<CaptureSpan> CaptureSpanOf(const std::vector<const flight::Photo*>& photos) {
  const flight::Photo* first = nullptr;
  const flight::Photo* last = nullptr;
  const flight::Photo* zoned = nullptr;  // the first that knows its zone: it is the flight's
  for (const flight::Photo* photo : photos) {
    if (!photo->captured_at) continue;
    if (first != nullptr && photo->captured_at_is_local != first->captured_at_is_local) {
      if (photo->captured_at_is_local) continue;
      first = last = nullptr;
    }
    if (first == nullptr || *photo->captured_at < *first->captured_at) first = photo;
    if (last == nullptr || *photo->captured_at > *last->captured_at) last = photo;
    if (photo->clock_minus_utc && (zoned == nullptr || *photo->captured_at < *zoned->captured_at))
      zoned = photo;
  }
  if (first == nullptr) return std::nullopt;
  const bool is_local = first->captured_at_is_local;
  const auto zone = zoned != nullptr ? zoned->clock_minus_utc : std::nullopt;
  return CaptureSpan{Written(*first->captured_at, is_local, zone),
                     Written(*last->captured_at, is_local, zone)};
}

namespace {

using Json = nlohmann::ordered_json;

double Rounded(double value, int digits) {
  const double scale = std::pow(10.0, digits);
  return std::round(value * scale) / scale;
}

// Names come from file systems and need not be UTF-8.
std::string Printed(const Json& json) { return JsonText(json, 2) + "\n"; }

std::string IsoTime(const flight::UtcTime& time) {
  const auto milliseconds = std::chrono::floor<std::chrono::milliseconds>(time);
  return fmt::format("{}.{:03}", flight::WrittenSecond(time),
                     (milliseconds - std::chrono::floor<std::chrono::seconds>(time)).count());
}

// Across the antimeridian longitudes go on beyond 180, as those of bounds do: with the sign changed half way
// the ring would go round the Earth.
Json FootprintRing(const alignment::AlignedPhoto& photo, const geo::LocalFrame& frame,
                   const ground::GroundSurface& ground) {
  std::vector<geo::LatLon> corners;
  double west_deg = 180.0, east_deg = -180.0;
  for (const Eigen::Vector2d& point :
       ground::FootprintOnGround(ground, photo.intrinsics, photo.cam_from_enu, 4)) {
    const geo::Wgs84 wgs84 = frame.Wgs84FromEnu({point.x(), point.y(), ground.HeightAt(point)});
    corners.push_back({.lat_deg = wgs84.lat_deg, .lon_deg = wgs84.lon_deg});
    west_deg = std::min(west_deg, wgs84.lon_deg);
    east_deg = std::max(east_deg, wgs84.lon_deg);
  }
  const bool is_across = east_deg - west_deg > 180.0;
  Json ring = Json::array();
  for (const geo::LatLon& corner : corners) {
    const double turn_deg = is_across && corner.lon_deg < 0.0 ? 360.0 : 0.0;
    ring.push_back({Rounded(corner.lon_deg + turn_deg, 9), Rounded(corner.lat_deg, 9)});
  }
  if (!ring.empty()) ring.push_back(ring.front());
  return ring;
}

Json OrNull(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json HeldAgainstJson(bands::HeldAgainst held_against) {
  if (held_against == bands::HeldAgainst::kPanel) return "panel";
  return held_against == bands::HeldAgainst::kTargets ? Json("targets") : Json(nullptr);
}

Json BandsJson(const bands::BandsReport& report) {
  Json bands = Json::array();
  for (const bands::BandReport& one : report.bands) {
    bands.push_back({{"name", one.band.name},
                     {"wavelength_nm", OrNull(one.band.wavelength_nm)},
                     {"width_nm", OrNull(one.band.width_nm)},
                     {"calibration", bands::CalibrationName(one.band.calibration)},
                     {"method", one.band.method},
                     {"held_against", HeldAgainstJson(one.band.held_against)},
                     {"pictures", one.pictures},
                     {"registered", one.registered},
                     {"patches", one.patches},
                     {"residual_px", Rounded(one.residual_px, 3)}});
  }
  return {{"reference_band", report.reference_band},
          {"captures", {{"total", report.captures_total}, {"placed", report.captures}}},
          {"gsd_m", Rounded(report.gsd_m, 6)},
          {"bands", bands}};
}

}  // namespace

bool CountsAsSurvey(const MosaicReport& report) {
  return report.align_report && report.align_report->survey_above_records_m;
}

double RaisedM(const MosaicReport& report) {
  return CountsAsSurvey(report) ? *report.align_report->survey_above_records_m : 0.0;
}

std::string ReportJson(const MosaicReport& report) {
  Json timings = Json::array();
  for (const StageTiming& timing : report.timings) {
    timings.push_back({{"stage", timing.stage},
                       {"wall_s", Rounded(timing.wall_s, 3)},
                       {"cpu_s", Rounded(timing.cpu_s, 3)}});
  }
  Json json;
  json["title"] = report.title;
  json["photos"] = {{"total", report.photos_total},
                    {"aligned", report.photos_aligned},
                    {"pose_only", report.photos_pose_only},
                    {"left_out", report.photos_left_out}};
  json["left_out_photos"] = JsonOfLeftOut<Json>(report.left_out_photos);
  json["captured"] = nullptr;
  if (report.captured)
    json["captured"] = {{"first", report.captured->first}, {"last", report.captured->last}};
  json["gsd_m"] = Rounded(report.gsd_m, 6);
  json["area_m2"] = Rounded(report.area_m2, 2);
  json["bounds"] = Json::array();
  for (const double bound : report.bounds.ToArray()) json["bounds"].push_back(Rounded(bound, 12));
  json["min_zoom"] = report.min_zoom;
  json["max_zoom"] = report.max_zoom;
  json["tile_size_px"] = report.tile_size_px;
  json["tile_count"] = report.tile_count;
  json["blocks"] = {{"total", report.blocks}, {"kept", report.blocks_kept}};
  json["height_rule"] = report.height_rule;
  json["is_placed"] = report.is_placed;
  json["quality"] = ParseOrderedJson(QualityJson(report.quality));
  json["timings"] = timings;
  json["peak_memory_bytes"] = report.peak_memory_bytes;
  json["warnings"] = flight::InWords(report.warnings);
  json["remarks"] = flight::JsonOfRemarks<Json>(report.warnings);
  json["poses"] = JsonOf<Json>(report.poses_report);
  json["ground"] = JsonOf<Json>(report.ground_report);
  json["seams"] = JsonOf<Json>(report.seam_shift);
  json["alignment"] = report.align_report ? JsonOf<Json>(*report.align_report) : Json(nullptr);
  if (report.bands) json["bands"] = BandsJson(*report.bands);
  if (report.ground_choice) {
    json["ground_choice"] = {
        {"surface", NameOf(IsUpright(*report.ground_choice) ? MapGround::kDense : MapGround::kSmooth)},
        {"leaning_share", Rounded(report.ground_choice->leaning_share, 4)},
        {"seen_share", Rounded(report.ground_choice->seen_share, 4)}};
  }
  if (report.surface) {
    json["surface"] = {{"cell_m", Rounded(report.surface->cell_m, 6)},
                       {"measured_share", Rounded(report.surface->measured_share, 4)},
                       {"heights_from", CountsAsSurvey(report) ? "survey" : "records"}};
    if (!CountsAsSurvey(report) && report.poses_report.heights_above_ellipsoid)
      json["surface"]["records_from"] =
          *report.poses_report.heights_above_ellipsoid ? "ellipsoid" : "take_off";
    if (report.surface->contour_interval_m)
      json["surface"]["contour_interval_m"] = *report.surface->contour_interval_m;
  }
  return Printed(json);
}

std::string PhotosGeoJson(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                          const AbsoluteAccuracy& absolute) {
  Json features = Json::array();
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    const Eigen::Vector3d camera_in_enu = photo.cam_from_enu.TargetOriginInSource();
    const geo::Wgs84 camera = flight.frame.Wgs84FromEnu(camera_in_enu);
    const poses::CameraAngles angles = poses::AnglesOf(photo.cam_from_enu.rotation);
    const Json ring = FootprintRing(photo, flight.frame, ground);
    Json properties;
    properties["name"] = photo.photo.name;
    properties["placement"] = alignment::PlacementName(photo.placement);
    properties["reason"] = flight::InOneLine(photo.placement_remarks);
    properties["remarks"] = flight::JsonOfRemarks<Json>(photo.placement_remarks);
    const std::optional<double> error_m = alignment::KnownErrorM(photo, ErrorsKnownOf(absolute));
    properties["error_radius_m"] = error_m ? Json(Rounded(*error_m, 3)) : Json(nullptr);
    properties["camera_lon"] = Rounded(camera.lon_deg, 9);
    properties["camera_lat"] = Rounded(camera.lat_deg, 9);
    properties["camera_height_above_ground_m"] =
        Rounded(camera_in_enu.z() - ground.HeightAt(camera_in_enu.head<2>()), 3);
    properties["yaw_deg"] = Rounded(geo::RadToDeg(angles.yaw_rad), 3);
    properties["pitch_deg"] = Rounded(geo::RadToDeg(angles.pitch_rad), 3);
    properties["roll_deg"] = Rounded(geo::RadToDeg(angles.roll_rad), 3);
    if (photo.photo.captured_at) {
      properties["captured_at"] =
          IsoTime(*photo.photo.captured_at) + (photo.photo.captured_at_is_local ? "" : "Z");
    } else {
      properties["captured_at"] = nullptr;
    }
    Json geometry = nullptr;
    if (!ring.empty()) geometry = {{"type", "Polygon"}, {"coordinates", Json::array({ring})}};
    features.push_back({{"type", "Feature"}, {"geometry", geometry}, {"properties", properties}});
  }
  return Printed({{"type", "FeatureCollection"}, {"features", features}});
}

}  // namespace skyquilt::pipeline
