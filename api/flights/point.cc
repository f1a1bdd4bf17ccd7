#include "api/flights/point.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/common/find_flight.h"
#include "api/common/locate.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "api/surface/map_surface.h"
#include "api/tiles/index_values.h"
#include "api/tiles/map_window.h"
#include "api/tiles/tiles.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"
#include "storage/files/publish_file.h"

namespace skyquilt::api {
namespace {

using PointValue = nlohmann::ordered_json;
using PixelColour = std::array<std::uint8_t, 4>;

// Of the finest zoom; nothing where the map has nothing.
Result<std::optional<PixelColour>> ColourAt(const storage::Tileset& tileset, const Eigen::Vector2d& merc) {
  SKYQUILT_TRY_ASSIGN(const image::RgbaImage pixel,
                      RenderWindow(tileset, WindowOfFinestPixel(tileset, merc)));
  if (pixel.rgba[3] == 0) return std::optional<PixelColour>();
  return std::optional(PixelColour{pixel.rgba[0], pixel.rgba[1], pixel.rgba[2], pixel.rgba[3]});
}

// The code of a layer at a place, "#rrggbb".
Result<std::optional<std::string>> CodeAt(const storage::Tileset& tileset, render::MapLayer layer,
                                          const Eigen::Vector2d& merc) {
  std::optional<std::string> code;
  const auto reader = tileset.layers.find(layer);
  if (reader == tileset.layers.end()) return code;
  const int zoom = storage::TilesetNumber(reader->second->metadata(), "maxzoom", tileset.revision.max_zoom);
  if (zoom < 0 || zoom > geo::kMaxZoom) return code;
  const geo::TileId tile = geo::TileId::AtMerc(zoom, merc);
  SKYQUILT_TRY_ASSIGN(std::optional<storage::FoundTile> found, reader->second->Find(tile));
  if (!found) return code;
  SKYQUILT_TRY_ASSIGN(const std::string bytes, reader->second->Load(*std::move(found)));
  SKYQUILT_TRY_ASSIGN(const image::RgbaImage picture, image::DecodePicture(bytes));
  const geo::Bounds2 bounds = tile.BoundsInMerc();
  const double share_x = (merc.x() - bounds.min.x()) / (bounds.max.x() - bounds.min.x());
  const double share_y = (bounds.max.y() - merc.y()) / (bounds.max.y() - bounds.min.y());
  const auto column = std::clamp(static_cast<int>(share_x * picture.width_px), 0, picture.width_px - 1);
  const auto row = std::clamp(static_cast<int>(share_y * picture.height_px), 0, picture.height_px - 1);
  const std::uint8_t* pixel = picture.Pixel(column, row);
  if (pixel[3] != 0) code = fmt::format("#{:02x}{:02x}{:02x}", pixel[0], pixel[1], pixel[2]);
  return code;
}

// The photo whose colour this is in the layer of photos.
Result<std::optional<std::string>> PhotoOfCode(Service& service, const std::string& flight_id,
                                               const std::string& code) {
  std::optional<std::string> name;
  SKYQUILT_TRY_ASSIGN(const ShownMap shown, FindShownMap(service, flight_id));
  const Result<storage::LocalBlob> legend = FetchProduct(service, shown, "layers.json");
  if (!legend) return name;
  SKYQUILT_TRY_ASSIGN(const std::string text, storage::ReadWholeFile(legend->path));
  const auto json = ParseJson(text);
  if (!json.is_object() || !json.contains("photo") || !json["photo"].contains("colours")) return name;
  for (const auto& entry : json["photo"]["colours"]) {
    if (entry.value("colour", "") == code) return std::optional(entry.value("photo", ""));
  }
  return name;
}

// Height and photo, of maps that have their cameras kept with them.
Result<void> AddGround(Service& service, const storage::Tileset& tileset, const Eigen::Vector2d& merc,
                       MapPoint& point) {
  const Result<pipeline::LocatedMap> located = ReadLocatedMap(service, point.flight_id);
  if (!located) {
    if (located.error().code == ErrorCode::kNotFound) return {};  // an imported map has none
    return located.error();
  }
  if (!point.rgba) return {};
  point.height_m = pipeline::GroundAt(*located, point.position).height_ellipsoid_m;
  const std::vector<pipeline::Sighting> sightings = pipeline::PhotosAtPoint(*located, point.position);
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> code, CodeAt(tileset, render::MapLayer::kPhoto, merc));
  if (code) {
    SKYQUILT_TRY_ASSIGN(const std::optional<std::string> name, PhotoOfCode(service, point.flight_id, *code));
    for (const pipeline::Sighting& sighting : sightings) {
      if (!name || sighting.photo != *name) continue;
      point.photo = sighting;
      point.is_photo_of_pixel = true;
      return {};
    }
  }
  if (!sightings.empty()) point.photo = sightings.front();
  return {};
}

PointValue AsJson(const MapPoint& point) {
  PointValue json;
  json["lon"] = point.position.lon_deg;
  json["lat"] = point.position.lat_deg;
  json["revision"] = point.revision;
  json["colour"] = nullptr;
  if (point.rgba) {
    const auto& [red, green, blue, alpha] = *point.rgba;
    json["colour"] = {{"red", red}, {"green", green}, {"blue", blue}, {"alpha", alpha}};
  }
  json["height_m"] = point.height_m ? PointValue(*point.height_m) : PointValue();
  json["photo"] = nullptr;
  if (point.photo) {
    json["photo"] = SightingJson(*point.photo);
    json["photo"]["is_of_pixel"] = point.is_photo_of_pixel;
  }
  return json;
}

// Of dsm and dtm, where the map has them.
Result<void> AddSurfaceHeights(Service& service, const MapPoint& point, PointValue& json) {
  SKYQUILT_TRY_ASSIGN(const std::vector<Surface> surfaces,
                      service.surfaces.Of(point.flight_id, point.revision));
  for (const Surface surface : surfaces) {
    SKYQUILT_TRY_ASSIGN(const auto heights, service.surfaces.Open(point.flight_id, point.revision, surface));
    SKYQUILT_TRY_ASSIGN(const std::vector<std::optional<double>> found,
                        heights->HeightsAt({&point.position, 1}));
    json[HeightKeyOf(surface)] = found.front() ? PointValue(*found.front()) : PointValue();
  }
  return {};
}

Result<std::string> AnswerPoint(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const double lon_deg, NumberParameter(request, "lon"));
  SKYQUILT_TRY_ASSIGN(const double lat_deg, NumberParameter(request, "lat"));
  SKYQUILT_TRY_ASSIGN(const geo::LatLon position, geo::LatLon::Make(lat_deg, lon_deg));
  SKYQUILT_TRY_ASSIGN(const std::optional<IndexLook> look, LookIn(request));
  const std::string_view ground = request.Query("ground").value_or("true");
  if (ground != "true" && ground != "false")
    return Error{ErrorCode::kInvalidArgument, "The parameter \"ground\" is true or false."};
  SKYQUILT_TRY_ASSIGN(const MapPoint point,
                      LookAt(service, request.Parameter("flight"), position, look, ground == "true"));
  PointValue json = AsJson(point);
  SKYQUILT_TRY(AddSurfaceHeights(service, point, json));
  if (look) {
    json["index"] = {{"title", look->title}, {"expression", look->text}, {"value", nullptr}};
    if (point.index_value) json["index"]["value"] = *point.index_value;
  }
  return JsonText(json);
}

}  // namespace

Result<MapPoint> LookAt(Service& service, const std::string& flight_id, const geo::LatLon& position,
                        const std::optional<IndexLook>& look, bool with_ground) {
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(flight_id));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight_id));
  MapPoint point;
  point.flight_id = flight_id;
  point.flight_name = flight.name;
  point.revision = tileset->revision.revision;
  point.position = position;
  // Windows of a map across the antimeridian go on beyond 180 degrees; its tiles and places do not.
  if (tileset->revision.bounds.east_deg > 180.0)
    point.position.lon_deg = std::remainder(position.lon_deg, 360.0);
  if (look) SKYQUILT_TRY(CheckBands(service.bands, *tileset, look->expression));
  // Beyond the square of the tiles there is no map.
  if (std::abs(position.lat_deg) > 85.0) return point;
  const Eigen::Vector2d merc = geo::MercFromLatLon(point.position);
  SKYQUILT_TRY_ASSIGN(point.rgba, ColourAt(*tileset, merc));
  if (look) {
    SKYQUILT_TRY_ASSIGN(point.index_value, ValueAt(service.bands, *tileset, look->expression, merc));
  }
  if (with_ground) SKYQUILT_TRY(AddGround(service, *tileset, merc, point));
  return point;
}

void AddPointRoute(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/point",
                    [&](const Request& request) -> Result<Response> {
                      SKYQUILT_TRY_ASSIGN(std::string answer, AnswerPoint(service, request));
                      return Json(200, std::move(answer));
                    });
}

}  // namespace skyquilt::api
