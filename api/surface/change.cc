#include "api/surface/change.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/http/responses.h"
#include "api/routes.h"
#include "api/surface/height_tiles.h"
#include "api/surface/map_surface.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tile_answer.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/web_mercator.h"
#include "core/image/rgba_image.h"
#include "core/surface/terrain/volume.h"
#include "storage/exports/custom/export_request.h"

namespace skyquilt::api {
namespace {

constexpr const char* kChangeTiles = "change";
// Two maps are compared on so many pixels a side at most, none smaller than this.
constexpr int kComparedSidePx = 1024;
constexpr double kComparedCellM = 0.25;
// Less than this, or than so many standard deviations, is not shown.
constexpr double kMinChangeM = 0.1, kSigmasShown = 2.0;

using FoundShift = std::variant<surface::HeightShift, surface::ShiftFault>;

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

double MinShownM(const surface::HeightShift& shift) {
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

Result<FoundShift> FindShift(HeightChange& change, const geo::LatLonBounds& now,
                             const geo::LatLonBounds& then) {
  const geo::LatLonBounds common = storage::Common(now, then);
  if (!(common.west_deg < common.east_deg) || !(common.south_deg < common.north_deg))
    return FoundShift(surface::ShiftFault::kTooLittle);
  const geo::Bounds2 both = geo::MercFromLatLonBounds(common);
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

Result<std::string> MakeChangeTile(const HeightChange& change, const geo::TileId& tile, double ground_m) {
  storage::MercGrid grid = HeightTileGrid(tile);
  SKYQUILT_TRY_ASSIGN(const storage::SampledHeights now, change.now->Over(grid));
  grid.west_m -= change.shift_merc_m.x();
  grid.north_m -= change.shift_merc_m.y();
  SKYQUILT_TRY_ASSIGN(const storage::SampledHeights then, change.then->Over(grid));
  const double min_m = MinShownM(change.shift);
  const double pixel_m = grid.pixel_width_m * ground_m;
  const auto aside_px = [&](const storage::HeightRaster& heights) {
    return surface::kStepsOffCells * std::max(1.0, heights.cell_m() / pixel_m);
  };
  const double now_aside_px = aside_px(*change.now), then_aside_px = aside_px(*change.then);
  image::RgbaImage picture = image::RgbaImage::Transparent(kHeightTilePx, kHeightTilePx);
  for (std::size_t i = 0; i < now.heights_m.size(); ++i) {
    const double change_m = now.heights_m[i] - then.heights_m[i] - change.shift.up_m;
    if (now.is_measured[i] == 0 || then.is_measured[i] == 0 || !(std::abs(change_m) >= min_m)) continue;
    // Edges of roofs and crowns stand aside in each flight by itself.
    const double steps_m = std::hypot(now_aside_px * surface::RiseAt(now.heights_m, kHeightTilePx, i),
                                      then_aside_px * surface::RiseAt(then.heights_m, kHeightTilePx, i));
    if (std::abs(change_m) < std::hypot(min_m, steps_m)) continue;
    const auto colour = ColourOfChange(change_m);
    std::copy(colour.begin(), colour.end(), picture.rgba.begin() + static_cast<std::ptrdiff_t>(4 * i));
    picture.rgba[4 * i + 3] = 255;
  }
  return EncodeTile(std::move(picture), image::PictureFormat::kPng);
}

Result<Earlier> RequiredEarlier(const Request& request) {
  SKYQUILT_TRY_ASSIGN(std::optional<Earlier> earlier, EarlierIn(request));
  if (earlier) return *std::move(earlier);
  return Error{ErrorCode::kInvalidArgument,
               "Since which flight? Name one of the same ground: since=ID, as /api/v1/flights lists them."};
}

// Where both maps are known: the address names their revisions, so that the bytes never change.
bool NamesBoth(const Request& request, const storage::Tileset& then) {
  return request.Query("since_rev") == std::to_string(then.revision.revision);
}

Result<Response> ChangeTile(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const Earlier earlier, RequiredEarlier(request));
  if (request.work < Work::kRead) return DeferTo(Work::kRead);
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> then,
                      service.tilesets.Get(earlier.flight_id));
  const std::string variant = fmt::format("{}-{}-{}{}", kChangeTiles, earlier.flight_id,
                                          then->revision.revision, earlier.is_aligned ? "" : "-as-placed");
  SKYQUILT_TRY_ASSIGN(
      Response answer,
      AnswerHeightTile(
          service, request, variant,
          [&](const storage::Tileset& shown, Surface surface,
              const geo::TileId& tile) -> Result<std::string> {
            SKYQUILT_TRY_ASSIGN(const std::shared_ptr<storage::HeightRaster> now,
                                service.surfaces.Open(shown.flight_id, shown.revision.revision, surface));
            SKYQUILT_TRY(CheckHeightZoom(*now, shown.revision, tile));
            SKYQUILT_TRY_ASSIGN(const HeightChange change,
                                ChangeSince(service, shown, *then, surface, earlier.is_aligned));
            return MakeChangeTile(change, tile,
                                  geo::GroundMetresPerMercMetre(shown.revision.bounds.Middle().lat_deg));
          }));
  if (!NamesBoth(request, *then) && answer.headers.Has("Cache-Control"))
    answer.headers.Set("Cache-Control", "no-cache");
  return answer;
}

Result<Response> ChangeTileJson(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const Earlier earlier, RequiredEarlier(request));
  SKYQUILT_TRY_ASSIGN(const storage::Flight before, service.catalogue.GetFlight(earlier.flight_id));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> then,
                      service.tilesets.Get(earlier.flight_id));
  return AnswerHeightTileJson(
      service, request, kChangeTiles,
      [&](const storage::Tileset& shown, Surface surface,
          nlohmann::ordered_json& json) -> Result<std::string> {
        SKYQUILT_TRY_ASSIGN(const HeightChange change,
                            ChangeSince(service, shown, *then, surface, earlier.is_aligned));
        json["name"] = fmt::format("{}, since {}", json["name"].get<std::string>(), before.name);
        json["since"] = before.id;
        json["shift"] = ShiftJson(change.shift);
        json["least_shown_m"] = MinShownM(change.shift);
        for (const ChangeStop& stop : kChangeStops)
          json["stops"].push_back({{"change_m", stop.change_m},
                                   {"colour", fmt::format("#{:02x}{:02x}{:02x}", stop.colour[0],
                                                          stop.colour[1], stop.colour[2])}});
        return fmt::format("&since={}&since_rev={}{}", before.id, then->revision.revision,
                           earlier.is_aligned ? "" : "&align=none");
      });
}

Error CannotCompare(surface::ShiftFault fault) {
  switch (fault) {
    case surface::ShiftFault::kTooLittle:
      return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFlightsNotCompared);
    case surface::ShiftFault::kTooFar:
      break;
  }
  return flight::Because(ErrorCode::kUnprocessable,
                         {flight::RemarkCode::kMapsFarApart, {{"most_m", surface::kMaxSidewaysM}}});
}

}  // namespace

Result<std::optional<Earlier>> EarlierIn(const Request& request) {
  const std::optional<std::string_view> since = request.Query("since");
  if (!since) return std::optional<Earlier>();
  Earlier earlier{std::string(*since)};
  SKYQUILT_TRY(CheckId(earlier.flight_id, "flight"));
  if (!request.only_flight.empty() && earlier.flight_id != request.only_flight)
    return Error{ErrorCode::kNotFound,
                 "This token opens one flight: its heights cannot be compared with another's."};
  if (earlier.flight_id == request.Parameter("flight"))
    return Error{ErrorCode::kInvalidArgument,
                 "The parameter \"since\" names another flight of the same ground."};
  const std::string_view align = request.Query("align").value_or("auto");
  if (align != "auto" && align != "none")
    return Error{
        ErrorCode::kInvalidArgument,
        "The parameter \"align\" is auto (what the two maps lie off each other is taken out) or none."};
  earlier.is_aligned = align == "auto";
  return std::optional(std::move(earlier));
}

nlohmann::ordered_json ShiftJson(const surface::HeightShift& shift) {
  const auto rounded = [](std::optional<double> metres) {
    return metres ? nlohmann::ordered_json(std::round(*metres * 1e3) / 1e3) : nlohmann::ordered_json();
  };
  const auto& sideways_m = shift.east_north_m;
  nlohmann::ordered_json json;
  json["east_m"] = rounded(sideways_m ? std::optional(sideways_m->x()) : std::nullopt);
  json["north_m"] = rounded(sideways_m ? std::optional(sideways_m->y()) : std::nullopt);
  json["up_m"] = rounded(shift.up_m);
  json["sigma_m"] = rounded(shift.sigma_m);
  json["alike_share"] = rounded(shift.alike_share);
  return json;
}

Result<HeightChange> ChangeSince(Service& service, const storage::Tileset& shown,
                                 const storage::Tileset& before, Surface surface, bool is_aligned) {
  const storage::Revision &now = shown.revision, &then = before.revision;
  HeightChange change;
  SKYQUILT_TRY_ASSIGN(change.now, service.surfaces.Open(shown.flight_id, now.revision, surface));
  Result<std::shared_ptr<storage::HeightRaster>> theirs =
      service.surfaces.Open(before.flight_id, then.revision, surface);
  if (!theirs && theirs.error().code == ErrorCode::kNotFound) {
    SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(before.flight_id));
    return Error{
        ErrorCode::kNotFound,
        fmt::format("The other flight, \"{}\", has no heights of this kind. Start a job of that flight with "
                    "\"heights\": \"{}\".",
                    flight.name, NameOf(surface))};
  }
  if (!theirs) return theirs.error();
  change.then = *std::move(theirs);
  if (!is_aligned) {
    change.shift.east_north_m = Eigen::Vector2d::Zero();
    return change;
  }
  const std::string both =
      fmt::format("{} {} {} {}", shown.flight_id, before.flight_id, then.revision, NameOf(surface));
  // The tiles of a first view ask all at once: one of them finds it.
  const std::lock_guard finding(service.height_shifts_mutex);
  SKYQUILT_TRY_ASSIGN(const FoundShift found, service.height_shifts.Of(both, now.revision, [&]() {
    return FindShift(change, now.bounds, then.bounds);
  }));
  if (const auto* const fault = std::get_if<surface::ShiftFault>(&found)) return CannotCompare(*fault);
  change.shift = std::get<surface::HeightShift>(found);
  change.shift_merc_m = change.shift.east_north_m.value_or(Eigen::Vector2d::Zero()) /
                        geo::GroundMetresPerMercMetre(now.bounds.Middle().lat_deg);
  return change;
}

void AddChangeRoutes(Router& router, Service& service) {
  AddHeightTileRoutes(router, service, kChangeTiles, ChangeTile, ChangeTileJson);
}

}  // namespace skyquilt::api
