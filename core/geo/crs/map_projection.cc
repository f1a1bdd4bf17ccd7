#include "core/geo/crs/map_projection.h"

#include <proj.h>

#include <cmath>
#include <string>
#include <utility>

namespace skyquilt::geo {

struct MapProjection::Impl {
  PJ_CONTEXT* context = proj_context_create();
  PJ* place_from_wgs84 = nullptr;
  bool is_in_radians = false;  // what place_from_wgs84 takes, else degrees
  bool is_geographic = false;
  bool is_north_first = false;

  Impl() { proj_log_level(context, PJ_LOG_NONE); }
  ~Impl() {
    proj_destroy(place_from_wgs84);
    proj_context_destroy(context);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // Nothing where PROJ has none.
  std::optional<Eigen::Vector2d> Apply(PJ_DIRECTION direction, double x, double y) const {
    proj_errno_reset(place_from_wgs84);  // of what failed before
    const PJ_COORD out = proj_trans(place_from_wgs84, direction, proj_coord(x, y, 0.0, HUGE_VAL));
    if (proj_errno(place_from_wgs84) != 0 || !std::isfinite(out.xy.x) || !std::isfinite(out.xy.y))
      return std::nullopt;
    return Eigen::Vector2d(out.xy.x, out.xy.y);
  }
};

namespace {

constexpr int kUtmNorth = 32600, kUtmSouth = 32700, kUtmZones = 60;

Error UnknownCode(int code, const char* why) {
  return {ErrorCode::kInvalidArgument, "EPSG:" + std::to_string(code) + " " + why, ""};
}

bool IsZone(int zone) { return zone >= 1 && zone <= kUtmZones; }

// Two horizontal axes on the Earth, in metres, feet or degrees.
bool IsPlane(PJ_CONTEXT* context, const PJ* crs) {
  const PJ_TYPE type = proj_get_type(crs);
  if (type != PJ_TYPE_PROJECTED_CRS && type != PJ_TYPE_GEOGRAPHIC_2D_CRS) return false;
  PJ* axes = proj_crs_get_coordinate_system(context, crs);
  const int count = axes == nullptr ? 0 : proj_cs_get_axis_count(context, axes);
  proj_destroy(axes);
  return count == 2;
}

// Whether the authority's coordinates are ours the other way round, by a place within its area.
bool IsSwapped(PJ* authority, PJ* ours) {
  double west = 0.0, south = 0.0, east = 0.0, north = 0.0;
  if (proj_get_area_of_use(nullptr, ours, &west, &south, &east, &north, nullptr) == 0 || west < -360.0) {
    west = south = 0.0;
    east = north = 20.0;
  }
  if (east < west) east += 360.0;
  // No symmetric place of the area, and of none with latitude like longitude.
  const PJ_COORD place =
      proj_coord(west + 0.371 * (east - west), south + 0.617 * (north - south), 0.0, HUGE_VAL);
  const PJ_COORD plain = proj_trans(ours, PJ_FWD, place);
  // The authority's transformation takes latitude and longitude of EPSG:4326.
  const PJ_COORD said = proj_trans(authority, PJ_FWD, proj_coord(place.xy.y, place.xy.x, 0.0, HUGE_VAL));
  return std::abs(said.xy.x - plain.xy.y) + std::abs(said.xy.y - plain.xy.x) <
         std::abs(said.xy.x - plain.xy.x) + std::abs(said.xy.y - plain.xy.y);
}

double LonFrom(double lon_deg) { return std::remainder(lon_deg, 360.0); }

}  // namespace

MapProjection::MapProjection(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapProjection::MapProjection(MapProjection&&) noexcept = default;
MapProjection& MapProjection::operator=(MapProjection&&) noexcept = default;
MapProjection::~MapProjection() = default;

Result<MapProjection> MapProjection::OfEpsg(int code) {
  auto impl = std::make_unique<Impl>();
  const bool is_north = IsZone(code - kUtmNorth), is_south = IsZone(code - kUtmSouth);
  if (is_north || is_south) {
    const std::string zone = std::to_string(code - (is_north ? kUtmNorth : kUtmSouth));
    const std::string definition = "+proj=utm +ellps=WGS84 +zone=" + zone + (is_south ? " +south" : "");
    impl->place_from_wgs84 = proj_create(impl->context, definition.c_str());
    impl->is_in_radians = true;
    if (impl->place_from_wgs84 == nullptr) return UnknownCode(code, "cannot be computed here.");
    return MapProjection(std::move(impl));
  }
  const std::string name = "EPSG:" + std::to_string(code);
  PJ* const crs = proj_create(impl->context, name.c_str());
  if (crs == nullptr) return UnknownCode(code, "is not known here.");
  const bool is_plane = IsPlane(impl->context, crs);
  impl->is_geographic = proj_get_type(crs) == PJ_TYPE_GEOGRAPHIC_2D_CRS;
  proj_destroy(crs);
  if (!is_plane) return UnknownCode(code, "is no map projection and not plain longitude and latitude.");
  PJ* const authority = proj_create_crs_to_crs(impl->context, "EPSG:4326", name.c_str(), nullptr);
  if (authority == nullptr) return UnknownCode(code, "cannot be computed here.");
  impl->place_from_wgs84 = proj_normalize_for_visualization(impl->context, authority);
  if (impl->place_from_wgs84 != nullptr) {
    impl->is_north_first = IsSwapped(authority, impl->place_from_wgs84);
  }
  proj_destroy(authority);
  if (impl->place_from_wgs84 == nullptr) return UnknownCode(code, "cannot be computed here.");
  return MapProjection(std::move(impl));
}

std::optional<LatLon> MapProjection::LatLonOf(const Eigen::Vector2d& place) const {
  const std::optional<Eigen::Vector2d> found = impl_->Apply(PJ_INV, place.x(), place.y());
  if (!found) return std::nullopt;
  LatLon position{.lat_deg = found->y(), .lon_deg = found->x()};
  if (impl_->is_in_radians) position = {.lat_deg = RadToDeg(found->y()), .lon_deg = RadToDeg(found->x())};
  position.lon_deg = LonFrom(position.lon_deg);
  // Beyond its domain an inverse may land anywhere: what does not lead back is no answer.
  const std::optional<Eigen::Vector2d> back = PlaceOf(position);
  if (!back) return std::nullopt;
  Eigen::Vector2d off = *back - place;
  if (impl_->is_geographic) off.x() = LonFrom(off.x());
  const double allowed = (impl_->is_geographic ? 1e-7 : 1e-2) + 1e-9 * place.cwiseAbs().maxCoeff();
  if (!(off.cwiseAbs().maxCoeff() <= allowed)) return std::nullopt;
  return position;
}

std::optional<Eigen::Vector2d> MapProjection::PlaceOf(const LatLon& position) const {
  const double lon = LonFrom(position.lon_deg), lat = position.lat_deg;
  return impl_->is_in_radians ? impl_->Apply(PJ_FWD, DegToRad(lon), DegToRad(lat))
                              : impl_->Apply(PJ_FWD, lon, lat);
}

bool MapProjection::is_geographic() const { return impl_->is_geographic; }
bool MapProjection::is_north_first() const { return impl_->is_north_first; }

}  // namespace skyquilt::geo
