#include "storage/exports/custom/boundary.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::storage {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kFewestCorners = 4;  // the last is the first again
constexpr int kDeepestJson = 12;           // a MultiPolygon in a collection of features has nine levels

Error NoBoundary(std::string why) {
  return {ErrorCode::kUnprocessable,
          "The boundary cannot be used: " + std::move(why) +
              " Give a GeoJSON Polygon or MultiPolygon with longitudes and latitudes of WGS 84 in degrees.",
          ""};
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

Result<void> AddObject(const Json& object, Boundary& boundary, std::size_t& corners) {
  const Json& type = Member(object, "type");
  const std::string kind = type.is_string() ? type.get<std::string>() : "";
  const Json& coordinates = Member(object, "coordinates");
  if (kind == "Polygon") return AddPolygon(coordinates, boundary, corners);
  if (kind == "MultiPolygon" && coordinates.is_array()) {
    for (const Json& polygon : coordinates) SKYQUILT_TRY(AddPolygon(polygon, boundary, corners));
    return {};
  }
  if (kind == "Feature" && Member(object, "geometry").is_object())
    return AddObject(Member(object, "geometry"), boundary, corners);
  if (kind == "FeatureCollection" && Member(object, "features").is_array()) {
    for (const Json& feature : Member(object, "features")) {
      if (!feature.is_object()) return NoBoundary("one of its features is none.");
      SKYQUILT_TRY(AddObject(feature, boundary, corners));
    }
    return {};
  }
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

}  // namespace

geo::LatLonBounds Boundary::Bounds() const {
  const geo::LatLon first = polygons.front().front().front();
  geo::LatLonBounds bounds{first.lon_deg, first.lat_deg, first.lon_deg, first.lat_deg};
  for (const Polygon& polygon : polygons) {
    for (const geo::LatLon& corner : polygon.front())
      bounds.Include({corner.lon_deg, corner.lat_deg, corner.lon_deg, corner.lat_deg});
  }
  return bounds;
}

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
  SKYQUILT_TRY(AddObject(parsed, boundary, corners));
  if (boundary.polygons.empty()) return NoBoundary("it has no polygon.");
  return boundary;
}

BoundaryOnZoom::BoundaryOnZoom(const Boundary& boundary, int zoom, int tile_size_px)
    : tile_size_px_(tile_size_px) {
  const double pixel_merc_m = geo::PixelSizeInMercM(zoom, tile_size_px);
  for (const Boundary::Polygon& polygon : boundary.polygons) {
    std::vector<Edge> edges;
    for (const Boundary::Ring& ring : polygon) {
      Eigen::Vector2d from = Eigen::Vector2d::Zero();
      for (std::size_t i = 0; i <= ring.size(); ++i) {
        // Beyond the square of the tiles there are none: clamped, a pole is not infinitely far.
        geo::LatLon corner = ring[i % ring.size()];
        corner.lat_deg = std::clamp(corner.lat_deg, -85.06, 85.06);
        const Eigen::Vector2d merc = geo::MercFromLatLon(corner);
        const Eigen::Vector2d to((merc.x() + geo::kMercHalfWidthM) / pixel_merc_m,
                                 (geo::kMercHalfWidthM - merc.y()) / pixel_merc_m);
        if (i > 0 && from.y() != to.y()) edges.push_back({from.x(), from.y(), to.x(), to.y()});
        from = to;
      }
    }
    polygons_.push_back(std::move(edges));
  }
}

Cover BoundaryOnZoom::Mask(const geo::TileId& tile, std::vector<std::uint8_t>& inside) const {
  const auto side = static_cast<std::size_t>(tile_size_px_);
  const double left = static_cast<double>(tile.x()) * tile_size_px_,
               top = static_cast<double>(tile.y()) * tile_size_px_;
  inside.assign(side * side, 0);
  std::vector<Edge> near;
  std::vector<double> crossings;
  // The first pixel whose middle lies at or beyond x.
  const auto first_from = [&](double x) {
    return static_cast<std::size_t>(std::clamp(std::ceil(x - left - 0.5), 0.0, static_cast<double>(side)));
  };
  for (const std::vector<Edge>& edges : polygons_) {
    near.clear();
    for (const Edge& edge : edges) {
      if (std::max(edge.y0, edge.y1) >= top && std::min(edge.y0, edge.y1) <= top + tile_size_px_)
        near.push_back(edge);
    }
    for (std::size_t row = 0; row < side && !near.empty(); ++row) {
      const double y = top + static_cast<double>(row) + 0.5;
      crossings.clear();
      for (const Edge& edge : near) {
        if ((edge.y0 <= y) == (edge.y1 <= y)) continue;
        crossings.push_back(edge.x0 + (y - edge.y0) / (edge.y1 - edge.y0) * (edge.x1 - edge.x0));
      }
      std::sort(crossings.begin(), crossings.end());
      for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
        const auto begin = inside.begin() + static_cast<std::ptrdiff_t>(row * side);
        std::fill(begin + static_cast<std::ptrdiff_t>(first_from(crossings[i])),
                  begin + static_cast<std::ptrdiff_t>(first_from(crossings[i + 1])), std::uint8_t{1});
      }
    }
  }
  const auto count = static_cast<std::size_t>(std::count(inside.begin(), inside.end(), std::uint8_t{1}));
  return count == 0 ? Cover::kNone : count == inside.size() ? Cover::kAll : Cover::kPart;
}

}  // namespace skyquilt::storage
