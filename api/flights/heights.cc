#include "api/flights/heights.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "api/common/locate.h"
#include "api/forms/geojson_body.h"
#include "api/json/json_text.h"
#include "api/routes.h"
#include "api/surface/map_surface.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/pipeline/report/ground_profile.h"

namespace skyquilt::api {
namespace {

using HeightsJson = nlohmann::ordered_json;

Error NoLine(const std::string& why) {
  return {ErrorCode::kUnprocessable,
          "The line cannot be used: " + why +
              " Give a GeoJSON LineString with longitudes and latitudes of WGS 84 in degrees."};
}

Result<geo::LatLon> PlaceOf(const HeightsJson& position) {
  const bool is_position = position.is_array() && position.size() >= 2 && position.size() <= 4 &&
                           position[0].is_number() && position[1].is_number();
  if (!is_position) return NoLine("one of its positions is not [longitude, latitude].");
  const Result<geo::LatLon> place = geo::LatLon::Make(position[1].get<double>(), position[0].get<double>());
  if (!place) return NoLine("one of its positions is no place in degrees.");
  return *place;
}

// To the tenth of a millimetre; degrees to the same.
double Rounded(double value, double steps) { return std::round(value * steps) / steps; }
double RoundedM(double metres) { return Rounded(metres, 1e4); }
double RoundedDeg(double degrees) { return Rounded(degrees, 1e9); }
HeightsJson MetresOrNull(const std::optional<double>& metres) {
  return metres ? HeightsJson(RoundedM(*metres)) : HeightsJson();
}

Result<std::string> ProfileJson(Service& service, const std::string& flight_id, std::string_view body) {
  SKYQUILT_TRY_ASSIGN(const std::vector<geo::LatLon> line, ParseLine(body));
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::Revision> revision,
                      service.catalogue.ActiveRevision(flight_id));
  SKYQUILT_TRY_ASSIGN(const pipeline::LocatedMap map, ReadLocatedMap(service, flight_id));
  if (!revision) return Error{ErrorCode::kNotFound, "This flight has no map yet."};
  SKYQUILT_TRY_ASSIGN(const pipeline::GroundProfile profile,
                      pipeline::ProfileGround(map, revision->bounds, line));
  HeightsJson json;
  json["revision"] = revision->revision;
  json["ground"] = map.ground.IsPlane() ? "plane" : "grid";
  json["cell_m"] = map.ground.IsPlane() ? HeightsJson() : HeightsJson(map.ground.CellSize());
  json["length_m"] = RoundedM(profile.length_m);
  json["step_m"] = RoundedM(profile.step_m);
  json["lowest_m"] = MetresOrNull(profile.lowest_m);
  json["highest_m"] = MetresOrNull(profile.highest_m);
  json["climb_m"] = RoundedM(profile.climb_m);
  json["descent_m"] = RoundedM(profile.descent_m);
  json["surfaces"] = HeightsJson::array();
  json["samples"] = HeightsJson::array();
  std::vector<geo::LatLon> places;
  for (const pipeline::ProfileSample& sample : profile.samples) {
    places.push_back(sample.position);
    json["samples"].push_back({{"distance_m", RoundedM(sample.distance_m)},
                               {"lon", RoundedDeg(sample.position.lon_deg)},
                               {"lat", RoundedDeg(sample.position.lat_deg)},
                               {"height_m", MetresOrNull(sample.height_m)}});
  }
  SKYQUILT_TRY_ASSIGN(const std::vector<Surface> surfaces,
                      service.surfaces.Of(flight_id, revision->revision));
  for (const Surface surface : surfaces) {
    SKYQUILT_TRY_ASSIGN(const auto heights, service.surfaces.Open(flight_id, revision->revision, surface));
    SKYQUILT_TRY_ASSIGN(const std::vector<std::optional<double>> heights_m, heights->HeightsAt(places));
    json["surfaces"].push_back(NameOf(surface));
    for (std::size_t i = 0; i < places.size(); ++i)
      json["samples"][i][HeightKeyOf(surface)] = MetresOrNull(heights_m[i]);
  }
  return JsonText(json);
}

}  // namespace

Result<std::vector<geo::LatLon>> ParseLine(std::string_view json) {
  SKYQUILT_TRY(CheckJsonText(json));
  const HeightsJson parsed = ParseOrderedJson(json);
  if (parsed.is_discarded()) return Error{ErrorCode::kInvalidArgument, "The body is not JSON."};
  const auto member = [](const HeightsJson& object, const char* name) {
    const auto found = object.find(name);
    return found == object.end() ? HeightsJson() : *found;
  };
  if (!parsed.is_object()) return NoLine("it is no JSON object.");
  const HeightsJson geometry = member(parsed, "type") == "Feature" ? member(parsed, "geometry") : parsed;
  if (!geometry.is_object() || member(geometry, "type") != "LineString")
    return NoLine("it is no LineString.");
  const HeightsJson positions = member(geometry, "coordinates");
  if (!positions.is_array()) return NoLine("it has no \"coordinates\".");
  if (positions.size() < 2 || positions.size() > pipeline::kMaxProfileCorners) {
    return NoLine(fmt::format("it has {} positions, and 2 to {} are taken.", positions.size(),
                              pipeline::kMaxProfileCorners));
  }
  std::vector<geo::LatLon> line;
  line.reserve(positions.size());
  for (const HeightsJson& position : positions) {
    SKYQUILT_TRY_ASSIGN(const geo::LatLon place, PlaceOf(position));
    line.push_back(place);
  }
  return line;
}

void AddHeightsRoute(Router& router, Service& service) {
  AddGeoJsonRoute(
      router, "/api/v1/flights/{flight}/heights", "line",
      [&service](const Request& request) -> Result<GeoJsonAnswer> {
        return GeoJsonAnswer([&service, flight = request.Parameter("flight")](const std::string& body) {
          return ProfileJson(service, flight, body);
        });
      });
}

}  // namespace skyquilt::api
