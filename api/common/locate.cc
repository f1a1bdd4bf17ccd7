#include "api/common/locate.h"

#include <nlohmann/json.hpp>

#include "api/common/find_flight.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "core/base/try.h"
#include "storage/files/publish_file.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

Result<Response> At(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const double lon_deg, NumberParameter(request, "lon"));
  SKYQUILT_TRY_ASSIGN(const double lat_deg, NumberParameter(request, "lat"));
  SKYQUILT_TRY_ASSIGN(const geo::LatLon position, geo::LatLon::Make(lat_deg, lon_deg));
  SKYQUILT_TRY_ASSIGN(const pipeline::LocatedMap map, ReadLocatedMap(service, request.Parameter("flight")));
  Value photos = Value::array();
  for (const pipeline::Sighting& sighting : pipeline::PhotosAtPoint(map, position)) {
    photos.push_back(SightingJson(sighting));
  }
  return JsonOf(200, {{"lon", lon_deg}, {"lat", lat_deg}, {"photos", photos}});
}

Result<Response> GroundOf(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const double x, NumberParameter(request, "x"));
  SKYQUILT_TRY_ASSIGN(const double y, NumberParameter(request, "y"));
  SKYQUILT_TRY_ASSIGN(const pipeline::LocatedMap map, ReadLocatedMap(service, request.Parameter("flight")));
  SKYQUILT_TRY_ASSIGN(const pipeline::GroundPoint point,
                      pipeline::GroundAtPixel(map, request.Parameter("name"), {x, y}));
  return JsonOf(200, {{"lon", point.position.lon_deg},
                      {"lat", point.position.lat_deg},
                      {"sigma_m", point.sigma_m ? Value(*point.sigma_m) : Value()}});
}

}  // namespace

Result<pipeline::LocatedMap> ReadLocatedMap(Service& service, const std::string& id) {
  SKYQUILT_TRY_ASSIGN(const ShownMap shown, FindShownMap(service, id));
  const Result<storage::LocalBlob> fetched = FetchProduct(service, shown, "locate.json");
  if (!fetched && fetched.error().code != ErrorCode::kNotFound) return fetched.error();
  const Result<std::string> text = fetched ? storage::ReadWholeFile(fetched->path) : fetched.error();
  if (!text)
    return Error{ErrorCode::kNotFound, "This map was made before cameras were kept with it. Stitch it again.",
                 shown.prefix};
  return pipeline::ParseLocateJson(*text);
}

nlohmann::ordered_json SightingJson(const pipeline::Sighting& sighting) {
  return {{"name", sighting.photo},
          {"x", sighting.pixel_in_image.x()},
          {"y", sighting.pixel_in_image.y()},
          {"off_nadir_deg", geo::RadToDeg(sighting.off_nadir_rad)},
          {"placement", alignment::PlacementName(sighting.placement)},
          {"sigma_m", sighting.sigma_m ? Value(*sighting.sigma_m) : Value()},
          {"sharpness", sighting.sharpness ? Value(*sighting.sharpness) : Value()},
          {"quality", sighting.quality}};
}

void AddLocateRoutes(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/at", On(service, At));
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/photos/{name}/ground", On(service, GroundOf));
}

}  // namespace skyquilt::api
