#include "storage/exports/custom/target_crs.h"

#include <ogr_spatialref.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

Error Unfit(int epsg, flight::RemarkCode why, std::map<std::string, flight::RemarkValue> values = {}) {
  values.emplace("epsg", epsg);
  return flight::Because(ErrorCode::kUnprocessable, {why, std::move(values)});
}

double LonAround(double lon_deg, double middle_deg) {
  return middle_deg + std::remainder(lon_deg - middle_deg, 360.0);
}

bool IsInArea(const OGRSpatialReference& reference, const geo::LatLon& at, std::string& area) {
  double west = 0.0, south = 0.0, east = 0.0, north = 0.0;
  const char* name = nullptr;
  if (!reference.GetAreaOfUse(&west, &south, &east, &north, &name) || west <= -1000.0) return true;
  area = name != nullptr ? name : "another part of the Earth";
  constexpr double kRoomDeg = 3.0;  // a zone is used a little beyond its edge
  const double width = std::remainder(east - west - 180.0, 360.0) + 180.0;
  if (width >= 354.0 || width <= 0.0) return at.lat_deg > south - kRoomDeg && at.lat_deg < north + kRoomDeg;
  const double middle = west + width / 2.0;
  return std::abs(LonAround(at.lon_deg, middle) - middle) < width / 2.0 + kRoomDeg &&
         at.lat_deg > south - kRoomDeg && at.lat_deg < north + kRoomDeg;
}

}  // namespace

Result<TargetCrs> FindTargetCrs(int epsg, const geo::LatLon& middle) {
  const QuietGdal quiet;
  OGRSpatialReference reference;
  if (reference.importFromEPSG(epsg) != OGRERR_NONE)
    return Unfit(epsg, flight::RemarkCode::kExportSystemUnknown);
  if (reference.IsCompound() && reference.StripVertical() == OGRERR_NONE) {
    const char* code = reference.GetAuthorityCode(nullptr);
    const int horizontal = code != nullptr ? std::atoi(code) : 0;
    if (horizontal > 0) return Unfit(horizontal, flight::RemarkCode::kExportSystemCompound);
  }
  if ((!reference.IsProjected() && !reference.IsGeographic()) || reference.IsCompound() ||
      reference.GetAxesCount() != 2) {
    return Unfit(epsg, flight::RemarkCode::kExportSystemNoPlane);
  }
  std::string area;
  if (!IsInArea(reference, middle, area))
    return Unfit(epsg, flight::RemarkCode::kExportSystemElsewhere,
                 {{"area_words", area},
                  {"lat_deg", middle.lat_deg},
                  {"lon_deg", std::remainder(middle.lon_deg, 360.0)}});
  reference.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  OGRSpatialReference wgs84;
  wgs84.importFromEPSG(4326);
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> transform(
      OGRCreateCoordinateTransformation(&wgs84, &reference));
  if (!transform) return Unfit(epsg, flight::RemarkCode::kExportSystemUnreachable);
  // Where the middle comes to lie, and points some hundred metres beside and north of it: east, or west where
  // the step would lead across the antimeridian, to the other end of many systems.
  constexpr double kStepDeg = 0.001;
  const double lon = std::remainder(middle.lon_deg, 360.0), lat = middle.lat_deg;
  const double beside = lon + kStepDeg > 180.0 ? lon - kStepDeg : lon + kStepDeg;
  double x[3] = {lon, beside, lon}, y[3] = {lat, lat, lat + kStepDeg};
  if (!transform->Transform(3, x, y) || !std::isfinite(x[0] + x[1] + x[2] + y[0] + y[1] + y[2]))
    return Unfit(epsg, flight::RemarkCode::kExportSystemUnreachable);
  const double sin_lat = std::sin(geo::DegToRad(lat));
  const double bend = 1.0 - geo::kWgs84EccentricitySquared * sin_lat * sin_lat;
  const double metre_east =
      geo::DegToRad(kStepDeg) * std::cos(geo::DegToRad(lat)) * geo::kWgs84SemiMajorM / std::sqrt(bend);
  const double metre_north = geo::DegToRad(kStepDeg) * geo::kWgs84SemiMajorM *
                             (1.0 - geo::kWgs84EccentricitySquared) / (bend * std::sqrt(bend));
  TargetCrs crs{std::hypot(x[1] - x[0], y[1] - y[0]) / metre_east,
                std::hypot(x[2] - x[0], y[2] - y[0]) / metre_north};
  if (reference.IsProjected()) {
    // Square pixels; and a metre of a surveyor's grid is taken for a metre on the ground.
    constexpr double kSurveyScale = 0.005;
    double scale = std::sqrt(crs.units_per_m_east * crs.units_per_m_north);
    const double units_per_m = 1.0 / reference.GetLinearUnits();
    if (std::abs(scale / units_per_m - 1.0) < kSurveyScale) scale = units_per_m;
    crs.units_per_m_east = crs.units_per_m_north = scale;
  }
  if (!(crs.units_per_m_east > 0.0) || !(crs.units_per_m_north > 0.0))
    return Unfit(epsg, flight::RemarkCode::kExportSystemUnreachable);
  return crs;
}

}  // namespace skyquilt::storage
