#include "api/tiles/map_crs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "api/http/http_message.h"
#include "api/http/parameters.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

constexpr int kMercatorCode = 3857, kLatLonCode = 4326;
constexpr const char* kOgcCrs = "http://www.opengis.net/def/crs/";

Error UnknownCrs(std::string_view text) {
  return {
      ErrorCode::kInvalidArgument,
      fmt::format("\"{}\" is no coordinate system that is known here. Name one as [OGC:CRS84], [EPSG:3857], "
                  "[EPSG:4326] or [EPSG:n], or by its URI, {}EPSG/0/n.",
                  text.substr(0, 100), kOgcCrs)};
}

bool TakePrefix(std::string_view& text, std::string_view prefix) {
  if (!EqualsIgnoringCase(text.substr(0, prefix.size()), prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

// "EPSG" and "3857" of all that names a system.
std::pair<std::string_view, std::string_view> AuthorityAndCode(std::string_view text) {
  char separator = ':';
  if (TakePrefix(text, "http://www.opengis.net/def/crs/") ||
      TakePrefix(text, "https://www.opengis.net/def/crs/")) {
    separator = '/';
  } else if (!TakePrefix(text, "urn:ogc:def:crs:") && text.starts_with('[') && text.ends_with(']')) {
    text = text.substr(1, text.size() - 2);
  }
  const std::size_t first = text.find(separator), last = text.rfind(separator);
  if (first == std::string_view::npos) return {"", text};
  return {text.substr(0, first), text.substr(last + 1)};
}

// A distance on the ground between places next to each other.
double GroundMetres(const geo::LatLon& a, const geo::LatLon& b) {
  const geo::Wgs84 first{.lat_deg = a.lat_deg, .lon_deg = a.lon_deg},
      second{.lat_deg = b.lat_deg, .lon_deg = b.lon_deg};
  return (geo::EcefFromWgs84(first) - geo::EcefFromWgs84(second)).norm();
}

// In merc of the middle of pixels whose rows and columns run along it.
MapWindow WindowAlongMerc(const geo::Bounds2& box, int width_px, int height_px, bool is_in_degrees) {
  const double width = box.Width() / width_px, height = box.Height() / height_px;
  const double west = box.min.x(), north = box.max.y();
  MapWindow window;
  window.width_px = width_px;
  window.height_px = height_px;
  if (!is_in_degrees) {
    window.pixel_m = std::min(width, height);
    window.x_in_merc = [=](int column) { return west + (column + 0.5) * width; };
    window.y_in_merc = [=](int row) { return north - (row + 0.5) * height; };
    return window;
  }
  const auto merc = [](double lat_deg, double lon_deg) {
    return geo::MercFromLatLon({.lat_deg = lat_deg, .lon_deg = lon_deg});
  };
  const double lat_deg = std::min(std::abs((box.min.y() + box.max.y()) / 2), 85.0);
  window.pixel_m = std::min(merc(0.0, width).x(), merc(lat_deg + height, 0.0).y() - merc(lat_deg, 0.0).y());
  window.x_in_merc = [=](int column) { return merc(0.0, west + (column + 0.5) * width).x(); };
  window.y_in_merc = [=](int row) {
    return merc(std::clamp(north - (row + 0.5) * height, -89.9, 89.9), 0.0).y();
  };
  return window;
}

}  // namespace

MapCrs MapCrs::Mercator() { return {Kind::kMercator, kMercatorCode}; }
MapCrs MapCrs::Crs84() { return {Kind::kDegrees, 0}; }

Result<MapCrs> MapCrs::OfEpsg(int code) {
  // 900913 is what Web Mercator was called before it had a code.
  if (code == kMercatorCode || code == 900913) return Mercator();
  if (code == kLatLonCode) {
    MapCrs crs(Kind::kDegrees, code);
    crs.is_north_first_ = true;
    return crs;
  }
  SKYQUILT_TRY_ASSIGN(geo::MapProjection projection, geo::MapProjection::OfEpsg(code));
  MapCrs crs(Kind::kProjected, code);
  crs.is_north_first_ = projection.is_north_first();
  crs.projection_ = std::make_shared<const geo::MapProjection>(std::move(projection));
  return crs;
}

Result<MapCrs> MapCrs::Named(std::string_view text) {
  const auto [authority, code] = AuthorityAndCode(text);
  // CRS84h has heights, which say nothing of a map.
  if ((authority.empty() || EqualsIgnoringCase(authority, "OGC") || EqualsIgnoringCase(authority, "CRS")) &&
      (EqualsIgnoringCase(code, "CRS84") || EqualsIgnoringCase(code, "CRS84h") ||
       (EqualsIgnoringCase(authority, "CRS") && code == "84"))) {
    return Crs84();
  }
  const auto epsg = ParseNumber<int>(code);
  if (!EqualsIgnoringCase(authority, "EPSG") || !epsg || *epsg < 1) return UnknownCrs(text);
  return OfEpsg(*epsg);
}

std::string MapCrs::uri() const {
  return is_crs84() ? fmt::format("{}OGC/1.3/CRS84", kOgcCrs) : fmt::format("{}EPSG/0/{}", kOgcCrs, epsg_);
}

std::optional<geo::LatLon> MapCrs::LatLonOf(const Eigen::Vector2d& place) const {
  if (!place.allFinite()) return std::nullopt;
  switch (kind_) {
    case Kind::kMercator:
      if (place.cwiseAbs().maxCoeff() > geo::kMercHalfWidthM * (1.0 + 1e-9)) return std::nullopt;
      return geo::LatLonFromMerc(place);
    case Kind::kDegrees:
      if (std::abs(place.y()) > 90.0) return std::nullopt;
      return geo::LatLon{.lat_deg = place.y(), .lon_deg = place.x()};
    case Kind::kProjected:
      return projection_->LatLonOf(place);
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> MapCrs::PlaceOf(const geo::LatLon& position) const {
  switch (kind_) {
    case Kind::kMercator:
      if (!(std::abs(position.lat_deg) < 89.9)) return std::nullopt;
      return geo::MercFromLatLon(position);
    case Kind::kDegrees:
      return Eigen::Vector2d(position.lon_deg, position.lat_deg);
    case Kind::kProjected:
      return projection_->PlaceOf(position);
  }
  return std::nullopt;
}

bool MapCrs::is_in_degrees() const {
  return kind_ == Kind::kDegrees || (projection_ && projection_->is_geographic());
}

std::optional<Eigen::Vector2d> MapCrs::MetresPerUnit(const Eigen::Vector2d& place) const {
  const double step = is_in_degrees() ? 1e-4 : 10.0;  // short on the ground
  Eigen::Vector2d metres;
  for (const int axis : {0, 1}) {
    const Eigen::Vector2d half = Eigen::Vector2d::Unit(axis) * (step / 2);
    const std::optional<geo::LatLon> before = LatLonOf(place - half), behind = LatLonOf(place + half);
    if (!before || !behind) return std::nullopt;
    metres[axis] = GroundMetres(*before, *behind) / step;
  }
  if (!(metres.minCoeff() > 0.0) || !metres.allFinite()) return std::nullopt;
  return metres;
}

MapWindow WindowOf(const MapCrs& crs, const geo::Bounds2& box, int width_px, int height_px,
                   const geo::LatLon& near) {
  if (crs.kind_ != MapCrs::Kind::kProjected)
    return WindowAlongMerc(box, width_px, height_px, crs.kind_ == MapCrs::Kind::kDegrees);
  const Eigen::Vector2d pixel(box.Width() / width_px, box.Height() / height_px);
  MapWindow window;
  window.width_px = width_px;
  window.height_px = height_px;
  const auto merc_at = [crs](const Eigen::Vector2d& place) -> Eigen::Vector2d {
    const std::optional<geo::LatLon> position = crs.LatLonOf(place);
    if (!position) return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    return geo::MercFromLatLon(*position);
  };
  // How wide its pixels are, where it is nearest to the map.
  const Eigen::Vector2d middle = (box.min + box.max) / 2;
  const Eigen::Vector2d place = crs.PlaceOf(near).value_or(middle).cwiseMax(box.min).cwiseMin(box.max);
  const auto width_at = [&](const Eigen::Vector2d& at) {
    const Eigen::Vector2d here = merc_at(at);
    const double x = (merc_at(at + Eigen::Vector2d(pixel.x(), 0.0)) - here).norm();
    const double y = (merc_at(at + Eigen::Vector2d(0.0, pixel.y())) - here).norm();
    return std::min(x, y);
  };
  window.pixel_m = width_at(place);
  if (!std::isfinite(window.pixel_m)) window.pixel_m = width_at(middle);
  if (!std::isfinite(window.pixel_m)) window.pixel_m = geo::kMercHalfWidthM;
  const Eigen::Vector2d corner(box.min.x(), box.max.y());
  window.merc_of = [=](double column, double row) {
    return merc_at(corner + Eigen::Vector2d(column * pixel.x(), -row * pixel.y()));
  };
  return window;
}

std::optional<geo::Bounds2> BoxIn(const MapCrs& to, const geo::Bounds2& box, const MapCrs& from) {
  if (to == from) return box;
  constexpr int kSteps = 32;
  geo::Bounds2 found;
  const auto include = [&](double along_x, double along_y) {
    const Eigen::Vector2d at(along_x, along_y);
    const std::optional<geo::LatLon> position = from.LatLonOf(box.min + at.cwiseProduct(box.max - box.min));
    if (!position) return;
    const std::optional<Eigen::Vector2d> there = to.PlaceOf(*position);
    if (there && there->allFinite()) found.Include(*there);
  };
  include(0.5, 0.5);
  for (int step = 0; step <= kSteps; ++step) {
    const double along = static_cast<double>(step) / kSteps;
    include(along, 0.0);
    include(along, 1.0);
    include(0.0, along);
    include(1.0, along);
  }
  if (found.IsEmpty()) return std::nullopt;
  return found;
}

std::optional<geo::Bounds2> BoxIn(const MapCrs& to, const geo::LatLonBounds& bounds) {
  geo::Bounds2 box;
  box.Include(Eigen::Vector2d(bounds.west_deg, bounds.south_deg));
  box.Include(Eigen::Vector2d(bounds.east_deg, bounds.north_deg));
  return BoxIn(to, box, MapCrs::Crs84());
}

}  // namespace skyquilt::api
