#include "core/pipeline/report/flight_facts.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/text/json_io.h"
#include "core/flight/remarks/remark_json.h"
#include "core/pipeline/report/cbor_values.h"
#include "core/pipeline/report/locate.h"
#include "core/pipeline/report/report_codec.h"

namespace skyquilt::render {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PhotoLight, gain, hot_spot)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SeamGrid, zoom, tile_size_px, cell_px, first_column, first_row, columns,
                                   rows)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SeamShift, patches, reliable, gsd_m, median_m, p90_m)

}  // namespace skyquilt::render

namespace skyquilt::pipeline {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GroundChoice, leaning_share, seen_share)

template <IsA<flight::RecordedPosition> Record, typename Visit>
void VisitFields(Record& record, Visit& visit) {
  visit("lat_deg", record.position.lat_deg);
  visit("lon_deg", record.position.lon_deg);
  visit("height_ellipsoid_m", record.height_ellipsoid_m);
  visit("height_amsl_m", record.height_amsl_m);
  visit("height_above_takeoff_m", record.height_above_takeoff_m);
  visit("height_above_ground_m", record.height_above_ground_m);
  visit("sigma_horizontal_m", record.sigma_horizontal_m);
  visit("sigma_vertical_m", record.sigma_vertical_m);
  visit.IfKnown("system_error_m", record.system_error_m);
  visit("is_rtk_fixed", record.is_rtk_fixed);
  visit("is_repeated", record.is_repeated);
}

namespace {

using Cbor = nlohmann::json;

// Raised whenever the meaning or a name changes (those of report_fields.h too), or alignment so much that a
// flight should be aligned anew.
constexpr int kVersion = 12;

Cbor OfExposure(const render::KnownExposure& exposure) {
  const auto& spot = exposure.light.directions.hot_spot;
  Cbor cameras = Cbor::array();
  for (const auto& [key, terms] : exposure.light.cameras) cameras.push_back({{"key", key}, {"terms", terms}});
  return {{"photos", exposure.photos},
          {"cameras", cameras},
          {"directions", exposure.light.of_directions},
          {"widest_look", exposure.light.directions.widest_look},
          {"hot_spot", spot ? Cbor{spot->x(), spot->y()} : Cbor(nullptr)}};
}

render::KnownExposure ToExposure(const Cbor& json) {
  render::KnownExposure exposure;
  exposure.photos = json.at("photos").get<std::vector<render::PhotoLight>>();
  exposure.light.of_directions = json.at("directions").get<std::array<render::DirectionTerms, 3>>();
  exposure.light.directions.widest_look = json.at("widest_look");
  if (const Cbor& look = json.at("hot_spot"); !look.is_null()) {
    const auto spot = look.get<std::array<double, 2>>();
    exposure.light.directions.hot_spot = Eigen::Vector2d(spot[0], spot[1]);
  }
  for (const Cbor& camera : json.at("cameras"))
    exposure.light.cameras[camera.at("key").get<std::string>()] =
        camera.at("terms").get<std::array<render::CameraTerms, 3>>();
  return exposure;
}

// Reports are kept as report.json has them; bytes of names that are not UTF-8 are replaced there too.
template <typename Report>
std::string ReportText(const Report& report) {
  return JsonText(JsonOf<nlohmann::ordered_json>(report));
}
template <typename Report>
Report OfReportText(const Cbor& text) {
  return ReportOf<Report>(ParseOrderedJson(text.get_ref<const std::string&>()));
}

// Runs of equal labels, row by row: photo, then how many cells. Between two fields lie more cells without any
// than a number of a run holds: those are several runs.
Cbor OfAppearance(const MapAppearance& appearance) {
  std::vector<std::int32_t> runs;
  for (int row = 0; row < appearance.labels.rows(); ++row) {
    for (int column = 0, alike = 0; column < appearance.labels.columns(); column += alike) {
      alike = appearance.labels.AlikeFrom(column, row);
      const std::int32_t label = appearance.labels.At(column, row);
      const bool goes_on = !runs.empty() && runs[runs.size() - 2] == label &&
                           runs.back() <= std::numeric_limits<std::int32_t>::max() - alike;
      if (!goes_on) runs.insert(runs.end(), {label, 0});
      runs.back() += alike;
    }
  }
  Cbor json = appearance.grid;
  json["gsd_m"] = appearance.gsd_m;
  json["exposure"] = OfExposure(appearance.exposure);
  json["upright"] = appearance.stands_upright;
  json["gsd_asked"] = appearance.is_gsd_asked;
  json["labels"] = CborOfValues<Cbor>(runs);
  return json;
}

MapAppearance ToAppearance(const Cbor& json, std::size_t photos) {
  MapAppearance appearance;
  appearance.gsd_m = json.at("gsd_m");
  appearance.exposure = ToExposure(json.at("exposure"));
  if (appearance.exposure.photos.size() > photos) ThrowDamaged<Cbor>("more light than photos");
  appearance.grid = json.get<render::SeamGrid>();
  appearance.stands_upright = json.value("upright", false);  // not in maps of earlier versions
  appearance.is_gsd_asked = json.value("gsd_asked", false);  // nor this
  constexpr int kMaxSideCells = 1 << 30;
  constexpr std::int64_t kMaxCells = std::int64_t{1} << 35;  // of fields far apart, most without a photo
  const std::int64_t cells = std::int64_t{appearance.grid.columns} * appearance.grid.rows;
  if (appearance.grid.columns < 0 || appearance.grid.rows < 0 || cells > kMaxCells ||
      std::max(appearance.grid.columns, appearance.grid.rows) > kMaxSideCells) {
    ThrowDamaged<Cbor>("the seam grid is of no size");
  }
  appearance.labels = render::SeamLabels(appearance.grid.columns, appearance.grid.rows);
  const auto runs = ValuesOfCbor<std::int32_t>(json.at("labels"));
  std::int64_t cell = 0;
  for (std::size_t run = 0; run + 1 < runs.size(); run += 2) {
    const bool is_photo = runs[run] >= 0 && static_cast<std::size_t>(runs[run]) < photos;
    if (!is_photo) cell += std::max(0, runs[run + 1]);
    for (std::int32_t k = 0; is_photo && k < runs[run + 1] && cell < cells; ++k, ++cell) {
      appearance.labels.Set(static_cast<int>(cell % appearance.grid.columns),
                            static_cast<int>(cell / appearance.grid.columns), runs[run]);
    }
  }
  return appearance;
}

// Polygons of rings of longitudes and latitudes in turn.
Cbor OfBoundary(const geo::Boundary& boundary) {
  Cbor polygons = Cbor::array();
  for (const geo::Boundary::Polygon& polygon : boundary.polygons) {
    Cbor rings = Cbor::array();
    for (const geo::Boundary::Ring& ring : polygon) {
      std::vector<double> places;
      for (const geo::LatLon& corner : ring) places.insert(places.end(), {corner.lon_deg, corner.lat_deg});
      rings.push_back(std::move(places));
    }
    polygons.push_back(std::move(rings));
  }
  return polygons;
}

geo::Boundary ToBoundary(const Cbor& polygons) {
  geo::Boundary boundary;
  for (const Cbor& rings : polygons) {
    geo::Boundary::Polygon& polygon = boundary.polygons.emplace_back();
    for (const Cbor& places : rings) {
      const auto numbers = places.get<std::vector<double>>();
      geo::Boundary::Ring& ring = polygon.emplace_back();
      for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) ring.push_back({numbers[i + 1], numbers[i]});
      if (ring.empty()) ThrowDamaged<Cbor>("a ring of the boundary is empty");
    }
    if (polygon.empty()) ThrowDamaged<Cbor>("a part of the boundary is empty");
  }
  if (boundary.polygons.empty()) ThrowDamaged<Cbor>("the boundary is empty");
  return boundary;
}

flight::SampleRange ToSampleRange(const Cbor& json) {
  const flight::SampleRange range{json.at(0).get<double>(), json.at(1).get<double>()};
  if (!(range.high > range.low)) ThrowDamaged<Cbor>("a range of samples is empty");
  return range;
}

FlightFacts Parse(std::string_view bytes) {
  const Cbor json = Cbor::from_cbor(bytes);
  FlightFacts facts;
  if (json.at("version") != kVersion) return facts;
  facts.options = DigestOfCbor(json.at("options"));
  if (json.contains("asked")) facts.asked = json.at("asked").get<std::map<std::string, std::string>>();
  if (json.contains("ground_choice")) facts.ground_choice = json.at("ground_choice").get<GroundChoice>();
  for (const Cbor& input : json.at("inputs")) {
    facts.inputs.push_back(
        {{TextOfCbor(input.at("name")), TextOfCbor(input.at("path"))}, DigestOfCbor(input.at("digest"))});
  }
  const Result<LocatedMap> located = ParseLocateJson(json.at("locate").get_ref<const std::string&>());
  if (!located) ThrowDamaged<Cbor>(located.error().message.c_str());
  facts.ground = located->ground;
  facts.flight.frame = located->frame;
  facts.flight.ground_z_in_enu_m = json.at("ground_z_m");
  facts.flight.warnings = flight::RemarksOfJson(json.at("warnings"));
  for (const Cbor& left_out : json.at("left_out")) {
    facts.flight.left_out.push_back({TextOfCbor(left_out.at("name")), left_out.at("code").get<ErrorCode>(),
                                     flight::RemarkOfJson(left_out.at("reason"))});
  }
  const Cbor& photos = json.at("photos");
  if (photos.size() != located->cameras.size()) {
    ThrowDamaged<Cbor>("numbers of photos differ");
  }
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const LocatedCamera& camera = located->cameras[i];
    alignment::AlignedPhoto photo;
    photo.photo.name = TextOfCbor(photos[i].at("name"));
    photo.photo.camera_key = TextOfCbor(photos[i].at("camera_key"));
    if (photos[i].contains("sample_range"))
      photo.photo.sample_range = ToSampleRange(photos[i]["sample_range"]);
    if (photos[i].contains("position"))
      photo.photo.position = ReportOf<flight::RecordedPosition>(photos[i]["position"]);
    photo.intrinsics = camera.intrinsics;
    photo.cam_from_enu = camera.cam_from_enu;
    photo.placement = camera.placement;
    photo.placement_remarks = flight::RemarksOfJson(photos[i].at("remarks"));
    photo.error_radius_m = camera.error_radius_m.value_or(0.0);
    photo.height_above_ground_m = photos[i].at("height_m");
    photo.readout_motion = camera.readout_motion;
    photo.sharpness = camera.sharpness;
    photo.max_look_rad = photos[i].value("max_look_rad", photo.max_look_rad);
    photo.tied_look_rad = photos[i].value("tied_look_rad", photo.tied_look_rad);
    const std::vector<std::uint8_t>& jpeg = photos[i].at("thumbnail").get_binary();
    facts.thumbnails.push_back(
        {photo.photo.name, photos[i].at("thumbnail_size").at(0), photos[i].at("thumbnail_size").at(1), jpeg});
    facts.flight.photos.push_back(std::move(photo));
  }
  facts.height_rule = json.at("height_rule");
  facts.is_placed = json.at("is_placed");
  facts.is_by_images = json.at("is_by_images");
  facts.is_by_hand = json.at("is_by_hand");
  const Cbor& align_report = json.at("alignment");
  if (align_report != "") facts.align_report = OfReportText<alignment::AlignReport>(align_report);
  facts.ground_report = OfReportText<ground::ModelGroundReport>(json.at("ground"));
  facts.poses_report = OfReportText<poses::PoseReport>(json.at("poses"));
  if (json.contains("boundary")) facts.boundary = ToBoundary(json.at("boundary"));
  if (const Cbor& appearance = json.at("look"); !appearance.is_null())
    facts.appearance = ToAppearance(appearance, photos.size());
  if (json.contains("seams")) facts.seams = json.at("seams").get<render::SeamShift>();
  return facts;
}

Error DamagedFacts(const char* detail) {
  return {ErrorCode::kCorrupt, "What an earlier run remembered of the flight is damaged.", detail};
}

}  // namespace

Digest DigestOfPlacing(const MosaicOptions& options) {
  Hasher hasher;
  hasher.Add(kVersion)
      .Add(static_cast<int>(options.method))
      .Add(options.landed_at_start)
      .Add(options.dem_path);
  hasher.Add(options.max_look_deg);
  hasher.Add(options.readout_s.has_value()).Add(options.readout_s.value_or(0.0));
  hasher.Add(options.origin.has_value());
  if (options.origin) hasher.Add(options.origin->lat_deg).Add(options.origin->lon_deg);
  if (!options.dem_path.empty()) {
    // One that cannot be read is refused where it is opened.
    if (const Result<Digest> dem = DigestOfFile(options.dem_path)) hasher.AddBytes(dem->data(), dem->size());
  }
  if (options.takeoff_height_amsl_m) hasher.Add(*options.takeoff_height_amsl_m);
  return hasher.Finish();
}

std::string WriteFacts(const FlightFacts& facts) {
  Cbor json;
  json["version"] = kVersion;
  json["options"] = CborOfDigest<Cbor>(facts.options);
  json["asked"] = facts.asked;
  if (facts.ground_choice) json["ground_choice"] = *facts.ground_choice;
  json["inputs"] = Cbor::array();
  for (const NamedDigest& input : facts.inputs) {
    json["inputs"].push_back({{"name", CborOfText<Cbor>(input.file.name)},
                              {"path", CborOfText<Cbor>(input.file.path.string())},
                              {"digest", CborOfDigest<Cbor>(input.digest)}});
  }
  json["locate"] = LocateJson(facts.flight, facts.ground);
  json["ground_z_m"] = facts.flight.ground_z_in_enu_m;
  json["warnings"] = flight::JsonOfRemarks<Cbor>(facts.flight.warnings);
  json["left_out"] = Cbor::array();
  for (const flight::LeftOutPhoto& photo : facts.flight.left_out) {
    json["left_out"].push_back({{"name", CborOfText<Cbor>(photo.name)},
                                {"code", photo.code},
                                {"reason", flight::JsonOfRemark<Cbor>(photo.reason)}});
  }
  json["photos"] = Cbor::array();
  for (std::size_t i = 0; i < facts.flight.photos.size(); ++i) {
    const alignment::AlignedPhoto& photo = facts.flight.photos[i];
    const render::Thumbnail& thumbnail = facts.thumbnails[i];
    json["photos"].push_back({{"name", CborOfText<Cbor>(photo.photo.name)},
                              {"camera_key", CborOfText<Cbor>(photo.photo.camera_key)},
                              {"remarks", flight::JsonOfRemarks<Cbor>(photo.placement_remarks)},
                              {"height_m", photo.height_above_ground_m},
                              {"max_look_rad", photo.max_look_rad},
                              {"tied_look_rad", photo.tied_look_rad},
                              {"thumbnail_size", {thumbnail.width_px, thumbnail.height_px}},
                              {"thumbnail", CborOfValues<Cbor>(thumbnail.jpeg)}});
    if (const auto& range = photo.photo.sample_range)
      json["photos"].back()["sample_range"] = {range->low, range->high};
    if (const auto& position = photo.photo.position)
      json["photos"].back()["position"] = JsonOf<Cbor>(*position);
  }
  json["height_rule"] = facts.height_rule;
  json["is_placed"] = facts.is_placed;
  json["is_by_images"] = facts.is_by_images;
  json["is_by_hand"] = facts.is_by_hand;
  json["alignment"] = facts.align_report ? ReportText(*facts.align_report) : "";
  json["ground"] = ReportText(facts.ground_report);
  json["poses"] = ReportText(facts.poses_report);
  if (facts.boundary) json["boundary"] = OfBoundary(*facts.boundary);
  json["look"] = facts.appearance ? OfAppearance(*facts.appearance) : Cbor(nullptr);
  if (facts.seams) json["seams"] = *facts.seams;
  const std::vector<std::uint8_t> bytes = Cbor::to_cbor(json);
  return {bytes.begin(), bytes.end()};
}

Result<FlightFacts> ParseFacts(std::string_view bytes) {
  try {
    return Parse(bytes);
  } catch (const Cbor::exception& broken) {
    return DamagedFacts(broken.what());
  }
}

Result<std::map<std::string, Digest>> DigestsOfFacts(std::string_view bytes) {
  try {
    const Cbor json = Cbor::from_cbor(bytes);
    std::map<std::string, Digest> digests;
    for (const Cbor& input : json.at("inputs"))
      digests.emplace(TextOfCbor(input.at("name")), DigestOfCbor(input.at("digest")));
    return digests;
  } catch (const Cbor::exception& broken) {
    return DamagedFacts(broken.what());
  }
}

}  // namespace skyquilt::pipeline
