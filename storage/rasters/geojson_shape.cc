#include "storage/rasters/geojson_shape.h"

#include <cpl_error.h>
#include <ogr_geometry.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

using ShapeJson = nlohmann::json;
using OgrShape = std::unique_ptr<OGRGeometry>;

constexpr int kDeepestShape = 16;  // a MultiPolygon in a collection has seven levels

Error NoShape(std::string why) {
  return {ErrorCode::kInvalidArgument, "This is no GeoJSON geometry: " + std::move(why), ""};
}

// Counts positions on the way, so that nothing is built beyond the limit.
class ShapeBuilder {
 public:
  Result<OgrShape> Geometry(const ShapeJson& json) {
    if (!json.is_object() || !json.contains("type") || !json["type"].is_string())
      return NoShape("it has no \"type\".");
    const std::string type = json["type"].get<std::string>();
    if (type == "GeometryCollection") return Collection(json);
    const auto coordinates = json.find("coordinates");
    if (coordinates == json.end() || !coordinates->is_array() || coordinates->empty())
      return NoShape("it has no \"coordinates\".");
    if (type == "Point") return Made(Point(*coordinates));
    if (type == "LineString") return Made(Curve<OGRLineString>(*coordinates, 2));
    if (type == "Polygon") return Made(Polygon(*coordinates));
    if (type == "MultiPoint")
      return Many<OGRMultiPoint>(*coordinates, [&](const ShapeJson& one) { return Point(one); });
    if (type == "MultiLineString")
      return Many<OGRMultiLineString>(*coordinates,
                                      [&](const ShapeJson& one) { return Curve<OGRLineString>(one, 2); });
    if (type == "MultiPolygon")
      return Many<OGRMultiPolygon>(*coordinates, [&](const ShapeJson& one) { return Polygon(one); });
    return NoShape("there is no type \"" + type.substr(0, 40) + "\".");
  }

 private:
  template <typename Kind>
  static Result<OgrShape> Made(Result<std::unique_ptr<Kind>> made) {
    if (!made) return made.error();
    return OgrShape(*std::move(made));
  }

  Result<std::pair<double, double>> Position(const ShapeJson& json) {
    const bool is_position =
        json.is_array() && json.size() >= 2 && json.size() <= 4 && json[0].is_number() && json[1].is_number();
    if (!is_position) return NoShape("one of its positions is not [longitude, latitude].");
    const double lon_deg = json[0].get<double>(), lat_deg = json[1].get<double>();
    if (!(std::abs(lon_deg) <= 360.0) || !(std::abs(lat_deg) <= 90.0))
      return NoShape("one of its positions is no place in degrees.");
    if (++positions_ > GeoJsonShape::kMaxPositions) return NoShape("it has too many positions; simplify it.");
    return std::pair(lon_deg, lat_deg);
  }

  Result<std::unique_ptr<OGRPoint>> Point(const ShapeJson& json) {
    SKYQUILT_TRY_ASSIGN(const auto position, Position(json));
    return std::make_unique<OGRPoint>(position.first, position.second);
  }

  template <typename Kind>
  Result<std::unique_ptr<Kind>> Curve(const ShapeJson& json, std::size_t fewest) {
    if (!json.is_array() || json.size() < fewest)
      return NoShape("one of its lines or rings has too few positions.");
    auto curve = std::make_unique<Kind>();
    for (const ShapeJson& corner : json) {
      SKYQUILT_TRY_ASSIGN(const auto position, Position(corner));
      curve->addPoint(position.first, position.second);
    }
    return curve;
  }

  Result<std::unique_ptr<OGRPolygon>> Polygon(const ShapeJson& json) {
    if (!json.is_array() || json.empty()) return NoShape("one of its polygons has no outline.");
    auto polygon = std::make_unique<OGRPolygon>();
    for (const ShapeJson& corners : json) {
      SKYQUILT_TRY_ASSIGN(auto ring, Curve<OGRLinearRing>(corners, 4));
      ring->closeRings();
      polygon->addRingDirectly(ring.release());
    }
    return polygon;
  }

  template <typename Kind, typename MakeOne>
  Result<OgrShape> Many(const ShapeJson& json, const MakeOne& make_one) {
    auto many = std::make_unique<Kind>();
    for (const ShapeJson& one : json) {
      SKYQUILT_TRY_ASSIGN(auto made, make_one(one));
      many->addGeometryDirectly(made.release());
    }
    return OgrShape(std::move(many));
  }

  Result<OgrShape> Collection(const ShapeJson& json) {
    const auto members = json.find("geometries");
    if (members == json.end() || !members->is_array() || members->empty())
      return NoShape("it has no \"geometries\".");
    auto collection = std::make_unique<OGRGeometryCollection>();
    for (const ShapeJson& member : *members) {
      SKYQUILT_TRY_ASSIGN(auto made, Geometry(member));
      collection->addGeometryDirectly(made.release());
    }
    return OgrShape(std::move(collection));
  }

  std::size_t positions_ = 0;
};

bool MeetsBox(const OGRGeometry& shape, double west, double south, double east, double north) {
  OGREnvelope around;
  shape.getEnvelope(&around);
  if (around.MinX > east || around.MaxX < west || around.MinY > north || around.MaxY < south) return false;
  OGRLinearRing ring;
  for (const auto& [x, y] :
       {std::pair(west, south), {east, south}, {east, north}, {west, north}, {west, south}})
    ring.addPoint(x, y);
  OGRPolygon box;
  box.addRing(&ring);
  // GEOS knows no predicates of collections.
  if (wkbFlatten(shape.getGeometryType()) == wkbGeometryCollection) {
    for (const OGRGeometry* member : *shape.toGeometryCollection()) {
      if (MeetsBox(*member, west, south, east, north)) return true;
    }
    return false;
  }
  return shape.Intersects(&box) != 0;
}

}  // namespace

struct GeoJsonShape::Geometry {
  OgrShape shape;
};

GeoJsonShape::GeoJsonShape(std::unique_ptr<Geometry> geometry) : geometry_(std::move(geometry)) {}
GeoJsonShape::GeoJsonShape(GeoJsonShape&&) noexcept = default;
GeoJsonShape& GeoJsonShape::operator=(GeoJsonShape&&) noexcept = default;
GeoJsonShape::~GeoJsonShape() = default;

Result<GeoJsonShape> GeoJsonShape::Parse(std::string_view geometry) {
  bool is_too_deep = false;
  const ShapeJson json = ShapeJson::parse(
      geometry,
      [&](int depth, ShapeJson::parse_event_t, ShapeJson&) {
        is_too_deep |= depth > kDeepestShape;
        return !is_too_deep;
      },
      false);
  if (is_too_deep) return NoShape("it is nested too deeply.");
  if (!json.is_object()) return NoShape("it is no JSON object.");
  SKYQUILT_TRY_ASSIGN(OgrShape shape, ShapeBuilder().Geometry(json));
  auto made = std::make_unique<Geometry>();
  made->shape = std::move(shape);
  return GeoJsonShape(std::move(made));
}

bool GeoJsonShape::Meets(const geo::LatLonBounds& box) const {
  CPLPushErrorHandler(CPLQuietErrorHandler);
  bool meets = false;
  for (const double turn_deg : {0.0, -360.0, 360.0}) {
    meets = meets || MeetsBox(*geometry_->shape, box.west_deg + turn_deg, box.south_deg,
                              box.east_deg + turn_deg, box.north_deg);
  }
  CPLPopErrorHandler();
  return meets;
}

}  // namespace skyquilt::storage
