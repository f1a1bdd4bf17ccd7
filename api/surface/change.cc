#include "api/surface/change.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/http/responses.h"
#include "api/routes.h"
#include "api/surface/height_tiles.h"
#include "api/surface/map_surface.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tile_answer.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/image/rgba_image.h"

namespace skyquilt::api {
namespace {

constexpr const char* kChangeTiles = "change";
// Two maps are compared on so many pixels a side at most, none smaller than this.
constexpr int kComparedSidePx = 512;
constexpr double kComparedCellM = 0.25;
// Less than this, or than so many standard deviations, is not shown.
constexpr double kMinChangeM = 0.1, kSigmasShown = 2.0;

struct ChangeStop {
  double change_m;
  std::array<std::uint8_t, 3> colour;
};
// Evenly apart for the eye; the same at every place and zoom, so that two views can be compared.
constexpr ChangeStop kChangeStops[] = {
    {-10.0, {103, 0, 31}},   {-3.0, {178, 24, 43}},  {-1.0, {214, 96, 77}},  {-0.3, {244, 165, 130}},
    {-0.1, {253, 219, 199}}, {0.1, {209, 229, 240}}, {0.3, {146, 197, 222}}, {1.0, {67, 147, 195}},
    {3.0, {33, 102, 172}},   {10.0, {5, 48, 97}}};

std::array<std::uint8_t, 3> ColourOfChange(double change_m) {
  const auto* const end = std::end(kChangeStops);
  const auto* const above = std::find_if(std::begin(kChangeStops), end,
                                         [&](const ChangeStop& stop) { return stop.change_m > change_m; });
  if (above == end) return std::prev(end)->colour;
  if (above == std::begin(kChangeStops)) return above->colour;
  const ChangeStop& below = *std::prev(above);
  const double share = (change_m - below.change_m) / (above->change_m - below.change_m);
  std::array<std::uint8_t, 3> colour{};
  for (std::size_t i = 0; i < colour.size(); ++i)
    colour[i] =
        static_cast<std::uint8_t>(std::lround((1 - share) * below.colour[i] + share * above->colour[i]));
  return colour;
}

double LeastShownM(const surface::HeightShift& shift) {
  return std::max(kMinChangeM, kSigmasShown * shift.sigma_m.value_or(0.0));
}

// What both maps may cover, on pixels that the coarser of them can tell apart.
storage::MercGrid ComparedGrid(const geo::Bounds2& both_merc, double pixel_merc_m) {
  const double longer = std::max(both_merc.Width(), both_merc.Height());
  const double pixel = std::max(pixel_merc_m, longer / kComparedSidePx);
  const auto count = [&](double length) {
    return std::clamp(static_cast<int>(length / pixel), 1, kComparedSidePx);
  };
  return {both_merc.min.x(),        both_merc.max.y(),        pixel, pixel,
          count(both_merc.Width()), count(both_merc.Height())};
}

void LeaveMeasured(storage::SampledHeights& sampled) {
  for (std::size_t i = 0; i < sampled.heights_m.size(); ++i) {
    if (sampled.is_measured[i] == 0) sampled.heights_m[i] = std::nanf("");
  }
}

Result<std::optional<surface::HeightShift>> FindShift(HeightChange& change, const geo::LatLonBounds& now,
                                                      const geo::LatLonBounds& then) {
  geo::Bounds2 both = geo::MercFromLatLonBounds(now);
  const geo::Bounds2 theirs = geo::MercFromLatLonBounds(then);
  both.min = both.min.cwiseMax(theirs.min);
  both.max = both.max.cwiseMin(theirs.max);
  if (both.IsEmpty()) return std::optional<surface::HeightShift>();
  const double ground_m = geo::GroundMetresPerMercMetre(now.Middle().lat_deg);
  const double cell_m = std::max({kComparedCellM, change.now->cell_m(), change.then->cell_m()});
  const storage::MercGrid grid = ComparedGrid(both, cell_m / ground_m);
  SKYQUILT_TRY_ASSIGN(storage::SampledHeights here, change.now->Over(grid));
  SKYQUILT_TRY_ASSIGN(storage::SampledHeights there, change.then->Over(grid));
  LeaveMeasured(here);
  LeaveMeasured(there);
  const double pixel_m = grid.pixel_width_m * ground_m;
  return surface::ShiftBetween({grid.width_px, grid.height_px, pixel_m, here.heights_m},
                               {grid.width_px, grid.height_px, pixel_m, there.heights_m});
}

Result<std::string> MakeChangeTile(const HeightChange& change, const geo::TileId& tile) {
  storage::MercGrid grid = HeightTileGrid(tile);
  SKYQUILT_TRY_ASSIGN(const storage::SampledHeights now, change.now->Over(grid));
  grid.west_m -= change.shift_merc_m.x();
  grid.north_m -= change.shift_merc_m.y();
  SKYQUILT_TRY_ASSIGN(const storage::SampledHeights then, change.then->Over(grid));
  const double least_m = LeastShownM(change.shift);
  image::RgbaImage picture = image::RgbaImage::Transparent(kHeightTilePx, kHeightTilePx);
  for (std::size_t i = 0; i < now.heights_m.size(); ++i) {
    const double change_m = now.heights_m[i] - then.heights_m[i] - change.shift.up_m;
    if (now.is_measured[i] == 0 || then.is_measured[i] == 0 || !(std::abs(change_m) >= least_m)) continue;
    const auto colour = ColourOfChange(change_m);
    std::copy(colour.begin(), colour.end(), picture.rgba.begin() + static_cast<std::ptrdiff_t>(4 * i));
    picture.rgba[4 * i + 3] = 255;
  }
  return EncodeTile(std::move(picture), image::PictureFormat::kPng);
}

Result<std::string> RequiredSince(const Request& request) {
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> since, SinceIn(request));
  if (since) return *since;
  return Error{ErrorCode::kInvalidArgument,
               "Since which flight? Name one of the same ground: since=ID, as /api/v1/flights lists them.",
               ""};
}

Result<Response> ChangeTile(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const std::string since, RequiredSince(request));
  if (request.work < Work::kRead) return DeferTo(Work::kRead);
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> then, service.tilesets.Get(since));
  const std::string variant = fmt::format("{} {} {}", kChangeTiles, since, then->revision.revision);
  SKYQUILT_TRY_ASSIGN(Response answer,
                      AnswerHeightTile(service, request, variant,
                                       [&](const storage::Tileset& shown, Surface surface,
                                           const geo::TileId& tile) -> Result<std::string> {
                                         SKYQUILT_TRY_ASSIGN(const HeightChange change,
                                                             ChangeSince(service, shown, surface, since));
                                         SKYQUILT_TRY(CheckHeightZoom(*change.now, shown.revision, tile));
                                         return MakeChangeTile(change, tile);
                                       }));
  // Bytes never change only where the address names the revisions of both.
  if (request.Query("since_rev") != std::to_string(then->revision.revision) &&
      answer.headers.Has("Cache-Control"))
    answer.headers.Set("Cache-Control", "no-cache");
  return answer;
}

Result<Response> ChangeTileJson(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const std::string since, RequiredSince(request));
  SKYQUILT_TRY_ASSIGN(const storage::Flight before, service.catalogue.GetFlight(since));
  return AnswerHeightTileJson(
      service, request, kChangeTiles,
      [&](const storage::Tileset& shown, Surface surface,
          nlohmann::ordered_json& json) -> Result<std::string> {
        SKYQUILT_TRY_ASSIGN(const HeightChange change, ChangeSince(service, shown, surface, since));
        json["name"] = fmt::format("{}, since {}", json["name"].get<std::string>(), before.name);
        json["since"] = since;
        json["shift"] = ShiftJson(change.shift);
        json["least_shown_m"] = LeastShownM(change.shift);
        for (const ChangeStop& stop : kChangeStops)
          json["stops"].push_back({{"change_m", stop.change_m},
                                   {"colour", fmt::format("#{:02x}{:02x}{:02x}", stop.colour[0],
                                                          stop.colour[1], stop.colour[2])}});
        return fmt::format("&since={}&since_rev={}", since, change.then_revision);
      });
}

}  // namespace

Result<std::optional<std::string>> SinceIn(const Request& request) {
  const std::optional<std::string_view> since = request.Query("since");
  if (!since) return std::optional<std::string>();
  std::string flight_id(*since);
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  if (!request.only_flight.empty() && flight_id != request.only_flight)
    return Error{ErrorCode::kNotFound,
                 "This token opens one flight: its heights cannot be compared with another's.", ""};
  return std::optional(std::move(flight_id));
}

nlohmann::ordered_json ShiftJson(const surface::HeightShift& shift) {
  const auto rounded = [](double metres) { return std::round(metres * 1e3) / 1e3; };
  nlohmann::ordered_json json;
  json["east_m"] = rounded(shift.east_north_m.x());
  json["north_m"] = rounded(shift.east_north_m.y());
  json["up_m"] = rounded(shift.up_m);
  json["sigma_m"] =
      shift.sigma_m ? nlohmann::ordered_json(rounded(*shift.sigma_m)) : nlohmann::ordered_json();
  return json;
}

Result<HeightChange> ChangeSince(Service& service, const storage::Tileset& shown, Surface surface,
                                 const std::string& since) {
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> before, service.tilesets.Get(since));
  const storage::Revision &now = shown.revision, &then = before->revision;
  HeightChange change;
  change.then_revision = then.revision;
  SKYQUILT_TRY_ASSIGN(change.now, OpenSurface(service, shown.flight_id, now.revision, surface));
  SKYQUILT_TRY_ASSIGN(change.then, OpenSurface(service, since, then.revision, surface));
  const std::string both = fmt::format("{} {} {} {}", shown.flight_id, since, then.revision, NameOf(surface));
  using Shift = std::optional<surface::HeightShift>;
  SKYQUILT_TRY_ASSIGN(const Shift shift, service.height_shifts.Of(both, now.revision, [&]() {
    return FindShift(change, now.bounds, then.bounds);
  }));
  if (!shift)
    return Error{ErrorCode::kUnprocessable,
                 "The two flights measured too little of the same ground to compare their heights.", ""};
  change.shift = *shift;
  change.shift_merc_m = shift->east_north_m / geo::GroundMetresPerMercMetre(now.bounds.Middle().lat_deg);
  return change;
}

void AddChangeRoutes(Router& router, Service& service) {
  AddHeightTileRoutes(router, service, kChangeTiles, ChangeTile, ChangeTileJson);
}

}  // namespace skyquilt::api
