#include "storage/exports/custom/boundary.h"

#include <fmt/core.h>
#include <tinyxml2.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::storage {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kFewestCorners = 4;  // the last is the first again
constexpr int kDeepestJson = 12;           // a MultiPolygon in a collection of features has nine levels
constexpr std::string_view kWhiteSpace = " \t\r\n";

Error NoBoundary(std::string why) {
  return flight::Because(ErrorCode::kUnprocessable,
                         {flight::RemarkCode::kFailBoundaryUnusable, {{"why_words", std::move(why)}}});
}

Result<geo::LatLon> CornerOf(const Json& position) {
  const bool is_position = position.is_array() && position.size() >= 2 && position.size() <= 4 &&
                           position[0].is_number() && position[1].is_number();
  if (!is_position) return NoBoundary("one of its positions is not [longitude, latitude].");
  const double lon_deg = position[0].get<double>(), lat_deg = position[1].get<double>();
  auto made = geo::LatLon::Make(lat_deg, lon_deg);
  if (!made) return NoBoundary(fmt::format("[{}, {}] is no place in degrees.", lon_deg, lat_deg));
  return made;
}

Result<void> AddPolygon(const Json& rings, Boundary& boundary, std::size_t& corners) {
  if (!rings.is_array() || rings.empty()) return NoBoundary("one of its polygons has no outline.");
  Boundary::Polygon polygon;
  for (const Json& positions : rings) {
    if (!positions.is_array() || positions.size() < kFewestCorners)
      return NoBoundary("one of its rings has fewer than four positions (the last is the first again).");
    corners += positions.size();
    if (corners > kMaxBoundaryCorners)
      return NoBoundary(fmt::format("it has more than {} corners; simplify it.", kMaxBoundaryCorners));
    Boundary::Ring ring;
    ring.reserve(positions.size());
    for (const Json& position : positions) {
      SKYQUILT_TRY_ASSIGN(const geo::LatLon corner, CornerOf(position));
      ring.push_back(corner);
    }
    polygon.push_back(std::move(ring));
  }
  boundary.polygons.push_back(std::move(polygon));
  return {};
}

const Json& Member(const Json& object, const char* name) {
  static const Json nothing;
  const auto found = object.find(name);
  return found == object.end() ? nothing : *found;
}

// Files of parcels and routes also have where the aircraft starts, lines, and rows without a shape.
bool IsPassedOver(std::string_view kind) {
  return kind == "Point" || kind == "MultiPoint" || kind == "LineString" || kind == "MultiLineString";
}

// Of a collection the polygons; what else it has is passed over, as in a KML.
Result<void> AddObject(const Json& object, bool is_in_collection, Boundary& boundary, std::size_t& corners) {
  const Json& type = Member(object, "type");
  const std::string kind = type.is_string() ? type.get<std::string>() : "";
  const Json& coordinates = Member(object, "coordinates");
  if (kind == "Polygon") return AddPolygon(coordinates, boundary, corners);
  if (kind == "MultiPolygon" && coordinates.is_array()) {
    for (const Json& polygon : coordinates) SKYQUILT_TRY(AddPolygon(polygon, boundary, corners));
    return {};
  }
  if (kind == "Feature" && Member(object, "geometry").is_object())
    return AddObject(Member(object, "geometry"), is_in_collection, boundary, corners);
  if (kind == "Feature" && Member(object, "geometry").is_null()) return {};
  const Json& members = Member(object, kind == "GeometryCollection" ? "geometries" : "features");
  if ((kind == "FeatureCollection" || kind == "GeometryCollection") && members.is_array()) {
    for (const Json& member : members) {
      if (!member.is_object()) return NoBoundary("one of its features is none.");
      SKYQUILT_TRY(AddObject(member, true, boundary, corners));
    }
    return {};
  }
  if (is_in_collection && IsPassedOver(kind)) return {};
  return NoBoundary(kind.empty() ? "it has no \"type\"." : "it has a " + kind.substr(0, 40) + ".");
}

// GeoJSON before RFC 7946 could name another coordinate system.
Result<void> CheckNamedCrs(const Json& object) {
  const Json& crs = Member(object, "crs");
  if (!crs.is_object() || !Member(crs, "properties").is_object()) return {};
  const Json& name = Member(Member(crs, "properties"), "name");
  if (!name.is_string()) return {};
  const std::string text = name.get<std::string>();
  if (text.ends_with("CRS84") || text.ends_with(":4326")) return {};
  return NoBoundary("its coordinates are of " + text.substr(0, 60) + ".");
}

std::string_view WithoutPrefix(const char* name) {
  const std::string_view whole = name;
  const std::size_t colon = whole.find(':');
  return colon == std::string_view::npos ? whole : whole.substr(colon + 1);
}

// "longitude,latitude[,height]" tuples, with white space between them.
Result<Boundary::Ring> RingOfKml(const tinyxml2::XMLElement& ring, std::size_t& corners) {
  const char* text = nullptr;
  for (auto* linear = ring.FirstChildElement(); linear != nullptr; linear = linear->NextSiblingElement()) {
    for (auto* inner = linear->FirstChildElement(); inner != nullptr; inner = inner->NextSiblingElement()) {
      if (WithoutPrefix(inner->Name()) == "coordinates" && text == nullptr) text = inner->GetText();
    }
  }
  Boundary::Ring corners_of_ring;
  const auto skip_space = [&] {
    while (text != nullptr && kWhiteSpace.find(*text) != std::string_view::npos) ++text;
  };
  for (skip_space(); text != nullptr && *text != 0; skip_space()) {
    char* end = nullptr;
    const double lon_deg = std::strtod(text, &end);
    if (end == text || *end != ',') return NoBoundary("one of its coordinates is not longitude,latitude.");
    const char* after = end + 1;
    const double lat_deg = std::strtod(after, &end);
    if (end == after) return NoBoundary("one of its coordinates is not longitude,latitude.");
    SKYQUILT_TRY_ASSIGN(const geo::LatLon corner, CornerOf(Json::array({lon_deg, lat_deg})));
    corners_of_ring.push_back(corner);
    if (++corners > kMaxBoundaryCorners)
      return NoBoundary(fmt::format("it has more than {} corners; simplify it.", kMaxBoundaryCorners));
    text = end;
    while (*text != 0 && kWhiteSpace.find(*text) == std::string_view::npos) ++text;  // the height
  }
  if (corners_of_ring.size() < kFewestCorners)
    return NoBoundary("one of its rings has fewer than four positions (the last is the first again).");
  return corners_of_ring;
}

// The polygons below an element, whatever folders, placemarks and collections they are in.
Result<void> AddKml(const tinyxml2::XMLElement& element, int depth, Boundary& boundary,
                    std::size_t& corners) {
  constexpr int kDeepestKml = 32;
  if (depth > kDeepestKml) return NoBoundary("it is nested too deeply.");
  if (WithoutPrefix(element.Name()) != "Polygon") {
    for (auto* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement())
      SKYQUILT_TRY(AddKml(*child, depth + 1, boundary, corners));
    return {};
  }
  Boundary::Polygon polygon;
  for (const std::string_view kind : {"outerBoundaryIs", "innerBoundaryIs"}) {
    for (auto* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
      if (WithoutPrefix(child->Name()) != kind) continue;
      SKYQUILT_TRY_ASSIGN(Boundary::Ring ring, RingOfKml(*child, corners));
      polygon.push_back(std::move(ring));
    }
    if (polygon.empty()) return NoBoundary("one of its polygons has no outline.");
  }
  boundary.polygons.push_back(std::move(polygon));
  return {};
}

Result<Boundary> ParseKml(std::string_view xml) {
  if (xml.size() > kMaxBoundaryBytes)
    return NoBoundary(fmt::format("it has more than {} MiB.", kMaxBoundaryBytes >> 20));
  tinyxml2::XMLDocument document;
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS || document.RootElement() == nullptr ||
      WithoutPrefix(document.RootElement()->Name()) != "kml") {
    return flight::Because(ErrorCode::kInvalidArgument, flight::RemarkCode::kFailBoundaryUnread);
  }
  Boundary boundary;
  std::size_t corners = 0;
  SKYQUILT_TRY(AddKml(*document.RootElement(), 0, boundary, corners));
  if (boundary.polygons.empty()) return NoBoundary("it has no polygon.");
  return boundary;
}

}  // namespace

Result<Boundary> ParseBoundary(std::string_view geojson) {
  if (geojson.size() > kMaxBoundaryBytes)
    return NoBoundary(fmt::format("it has more than {} MiB.", kMaxBoundaryBytes >> 20));
  bool is_too_deep = false;
  const Json parsed = Json::parse(
      geojson,
      [&](int depth, Json::parse_event_t, Json&) {
        is_too_deep |= depth > kDeepestJson;
        return !is_too_deep;
      },
      false);
  if (is_too_deep) return NoBoundary("it is nested too deeply.");
  if (!parsed.is_object())
    return Error{ErrorCode::kInvalidArgument,
                 "The boundary is not JSON. Give a GeoJSON Polygon or MultiPolygon.", ""};
  SKYQUILT_TRY(CheckNamedCrs(parsed));
  Boundary boundary;
  std::size_t corners = 0;
  SKYQUILT_TRY(AddObject(parsed, false, boundary, corners));
  if (boundary.polygons.empty()) return NoBoundary("it has no polygon.");
  return boundary;
}

Result<Boundary> ParseArea(std::string_view geojson) {
  SKYQUILT_TRY_ASSIGN(Boundary boundary, ParseBoundary(geojson));
  if (geo::CrossesItself(boundary))
    return NoBoundary("one of its rings crosses itself: put its corners in the order along the outline.");
  return boundary;
}

Result<Boundary> ParseBoundaryFile(std::string_view bytes) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
  if (bytes.starts_with("PK\x03\x04"))
    return flight::Because(ErrorCode::kInvalidArgument, flight::RemarkCode::kFailBoundaryZipped);
  const std::size_t first = bytes.find_first_not_of(kWhiteSpace);
  if (first != std::string_view::npos && bytes[first] == '<') return ParseKml(bytes.substr(first));
  return ParseBoundary(bytes);
}

}  // namespace skyquilt::storage
