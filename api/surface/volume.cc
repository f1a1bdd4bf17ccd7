// POST /api/v1/flights/{flight}/volume: what lies above and below a base, or the heights of an earlier
// flight, within a polygon of a map's heights (core/surface/terrain/volume). Any thread; reads up to eight
// million cells. Errors: kInvalidArgument (no JSON, no such base), kUnprocessable (no polygon, one that
// crosses itself, no height within or along it, or a map whose scale is a guess), kNotFound (no such flight,
// no map, or one without heights), kCorrupt, and those of fetching.
#include "core/surface/terrain/volume.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "api/common/locate.h"
#include "api/forms/geojson_body.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/json/json_text.h"
#include "api/routes.h"
#include "api/surface/change.h"
#include "api/surface/map_surface.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/pipeline/report/map_quality.h"
#include "storage/exports/custom/boundary.h"

namespace skyquilt::api {
namespace {

using VolumeJson = nlohmann::ordered_json;

constexpr double kMaxHeightM = 20'000.0;

struct Base {
  surface::VolumeBase kind = surface::VolumeBase::kLowest;
  double given_m = 0.0;
  std::optional<Earlier> since = std::nullopt;  // the flight whose heights are the base instead
};

const char* NameOfBase(surface::VolumeBase base) {
  switch (base) {
    case surface::VolumeBase::kLowest:
      return "lowest";
    case surface::VolumeBase::kPlane:
      return "plane";
    case surface::VolumeBase::kGiven:
      break;
  }
  return "given";
}

Result<Base> BaseIn(const Request& request) {
  SKYQUILT_TRY_ASSIGN(const std::optional<Earlier> since, EarlierIn(request));
  if (since && request.Query("base"))
    return Error{ErrorCode::kInvalidArgument,
                 "The base is either the heights of the flight of \"since\" or what \"base\" says."};
  if (since) return Base{.since = since};
  const std::string_view text = request.Query("base").value_or("lowest");
  if (text == "lowest") return Base{surface::VolumeBase::kLowest};
  if (text == "plane") return Base{surface::VolumeBase::kPlane};
  SKYQUILT_TRY_ASSIGN(const double given_m, NumberParameter(request, "base"));
  if (std::abs(given_m) <= kMaxHeightM) return Base{surface::VolumeBase::kGiven, given_m};
  return Error{ErrorCode::kInvalidArgument, "The parameter \"base\" is lowest, plane or a height in metres."};
}

// To the litre and the millimetre.
double RoundedTo3(double value) { return std::round(value * 1e3) / 1e3; }

Error UnusableArea(flight::RemarkCode why) { return flight::Because(ErrorCode::kUnprocessable, why); }

// Cubic metres of a map that is as large as a guess would be believed.
bool IsScaleGuessed(const storage::Tileset& map) {
  const auto quality = pipeline::ParseQuality(map.revision.quality);
  return quality && quality->IsLimitedBy(pipeline::LimitKind::kScaleGuessed);
}

Result<std::string> VolumeText(Service& service, const std::string& flight_id, std::string_view polygon,
                               Surface surface, const Base& base) {
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY(CheckJsonText(polygon));
  SKYQUILT_TRY_ASSIGN(const storage::Boundary area, storage::ParseArea(polygon));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight_id));
  if (IsScaleGuessed(*tileset)) return UnusableArea(flight::RemarkCode::kVolumeWithoutScale);
  const std::int64_t revision = tileset->revision.revision;
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<storage::HeightRaster> heights,
                      service.surfaces.Open(flight_id, revision, surface));
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::HeightCells> cells, heights->Within(area));
  if (!cells) return UnusableArea(flight::RemarkCode::kVolumeWithoutHeights);
  const surface::AreaHeights inside{cells->columns,   cells->rows,        cells->cell_m,
                                    cells->heights_m, cells->is_measured, cells->is_inside};
  std::optional<surface::AreaVolume> volume;
  std::optional<surface::HeightShift> shift;
  if (base.since) {
    SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> before,
                        service.tilesets.Get(base.since->flight_id));
    if (IsScaleGuessed(*before)) return UnusableArea(flight::RemarkCode::kVolumeWithoutScale);
    SKYQUILT_TRY_ASSIGN(const HeightChange change,
                        ChangeSince(service, *tileset, *before, surface, base.since->is_aligned));
    shift = change.shift;
    SKYQUILT_TRY_ASSIGN(storage::SampledHeights then, change.then->On(*cells, change.shift_merc_m));
    for (float& height_m : then.heights_m) height_m += static_cast<float>(shift->up_m);
    volume = surface::VolumeSince(inside,
                                  {then.heights_m, then.is_measured, shift->sigma_m, change.then->cell_m()});
    if (!volume) return UnusableArea(flight::RemarkCode::kVolumeWithoutHeightsOfBoth);
  } else {
    if (cells->edge.empty() && base.kind != surface::VolumeBase::kGiven)
      return UnusableArea(flight::RemarkCode::kVolumeWithoutHeights);
    volume = surface::VolumeOver(inside, cells->edge, base.kind, base.given_m);
    if (!volume) return UnusableArea(flight::RemarkCode::kVolumeWithoutHeights);
  }
  VolumeJson json;
  json["revision"] = revision;
  json["of"] = NameOf(surface);
  json["base"] = base.since ? "flight" : NameOfBase(base.kind);
  if (shift) {
    json["since"] = base.since->flight_id;
    json["shift"] = ShiftJson(*shift);
  }
  json["base_m"] = RoundedTo3(volume->base_m);
  // Of the polygon, also of what of it lies beside the map; cells whose middles lie in it may come to more.
  const double area_m2 = std::max(geo::AreaM2(area), volume->area_m2);
  json["area_m2"] = RoundedTo3(area_m2);
  json["covered_m2"] = RoundedTo3(volume->area_m2);
  json["measured_share"] = RoundedTo3(volume->measured_share * volume->area_m2 / area_m2);
  json["cell_m"] = cells->cell_m;
  json["cut_m3"] = RoundedTo3(volume->cut_m3);
  json["fill_m3"] = RoundedTo3(volume->fill_m3);
  json["net_m3"] = RoundedTo3(volume->cut_m3 - volume->fill_m3);
  json["net_sigma_m3"] = volume->net_sigma_m3 ? VolumeJson(RoundedTo3(*volume->net_sigma_m3)) : VolumeJson();
  json["lowest_m"] = RoundedTo3(volume->lowest_m);
  json["highest_m"] = RoundedTo3(volume->highest_m);
  json["mean_m"] = RoundedTo3(volume->mean_m);
  return JsonText(json);
}

}  // namespace

void AddVolumeRoute(Router& router, Service& service) {
  AddGeoJsonRoute(router, "/api/v1/flights/{flight}/volume", "polygon",
                  [&service](const Request& request) -> Result<GeoJsonAnswer> {
                    SKYQUILT_TRY_ASSIGN(const Surface surface, SurfaceIn(request));
                    SKYQUILT_TRY_ASSIGN(const Base base, BaseIn(request));
                    return GeoJsonAnswer([&service, flight = request.Parameter("flight"), surface,
                                          base](const std::string& body) {
                      return VolumeText(service, flight, body, surface, base);
                    });
                  });
}

}  // namespace skyquilt::api
