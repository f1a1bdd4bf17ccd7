// What a map shows within a polygon: its area, how much of it the map covers, and of each colour the least,
// the greatest, the mean, the spread and a histogram; the same of an index, with percentiles. Of the finest
// zoom at which the polygon has at most kMaxPixels pixels; the answer says which. Any thread; takes up to
// half a second, with a slow expression up to three. Errors: kInvalidArgument, kUnprocessable (no polygon, or
// one that crosses itself), kNotFound (no such flight, or no map yet), kCorrupt, kIo.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/common/index_look.h"
#include "api/forms/geojson_body.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/json/json_text.h"
#include "api/routes.h"
#include "api/tiles/index_values.h"
#include "api/tiles/tiles.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"
#include "core/indices/value_summary.h"
#include "storage/exports/custom/export_request.h"

namespace skyquilt::api {
namespace {

constexpr double kMaxPixels = 8 << 20;
constexpr double kMinPixels = 1024;

using StatisticsJson = nlohmann::ordered_json;

constexpr std::array kBandNames = {"red", "green", "blue"};

struct BandCount {
  std::array<std::int64_t, 256> histogram{};

  StatisticsJson Told(std::int64_t pixels, const char* name) const {
    StatisticsJson told = {
        {"name", name}, {"min", nullptr}, {"max", nullptr}, {"mean", nullptr}, {"std", nullptr}};
    double sum = 0.0, squares = 0.0;
    int least = 255, greatest = 0;
    for (int value = 0; value < 256; ++value) {
      const std::int64_t count = histogram[static_cast<std::size_t>(value)];
      if (count == 0) continue;
      least = std::min(least, value);
      greatest = value;
      sum += static_cast<double>(count) * value;
      squares += static_cast<double>(count) * value * value;
    }
    if (pixels > 0) {
      const double mean = sum / static_cast<double>(pixels);
      told["min"] = least;
      told["max"] = greatest;
      told["mean"] = mean;
      told["std"] = std::sqrt(std::max(0.0, squares / static_cast<double>(pixels) - mean * mean));
    }
    told["histogram"] = histogram;
    return told;
  }
};

// Of what polygon and map have in common; absent: nothing.
std::optional<geo::Bounds2> CommonInMerc(const storage::Boundary& boundary,
                                         const storage::Revision& revision) {
  geo::LatLonBounds common = storage::Common(revision.bounds, boundary.Bounds());
  common.south_deg = std::max(common.south_deg, -85.05);
  common.north_deg = std::min(common.north_deg, 85.05);
  if (!(common.west_deg < common.east_deg) || !(common.south_deg < common.north_deg)) return std::nullopt;
  return geo::MercFromLatLonBounds(common);
}

class StatisticsCounter {
 public:
  StatisticsCounter(const storage::Tileset& tileset, const storage::Boundary& boundary, int zoom)
      : tileset_(tileset),
        side_px_(TileSizePx(tileset)),
        pixel_m_(geo::PixelSizeInMercM(zoom, side_px_)),
        mask_(boundary, zoom, side_px_) {}

  Result<void> Add(const geo::TileId& tile) {
    if (mask_.Mask(tile, inside_) == storage::Cover::kNone) return {};
    SKYQUILT_TRY_ASSIGN(std::optional<storage::FoundTile> found, tileset_.reader->Find(tile));
    if (!found) return {};
    SKYQUILT_TRY_ASSIGN(const std::string bytes, tileset_.reader->Load(*std::move(found)));
    SKYQUILT_TRY_ASSIGN(const image::RgbaImage picture, image::DecodePicture(bytes));
    if (picture.width_px != side_px_ || picture.height_px != side_px_)
      return Error{ErrorCode::kCorrupt, "A stored tile has another size than its map says."};
    const double top_m = tile.BoundsInMerc().max.y();
    for (int row = 0; row < side_px_; ++row) {
      std::int64_t in_row = 0;
      for (int column = 0; column < side_px_; ++column) {
        const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(side_px_) +
                        static_cast<std::size_t>(column);
        const std::uint8_t* pixel = picture.rgba.data() + 4 * at;
        if (inside_[at] == 0 || pixel[3] < kSolidMapAlpha) continue;
        ++in_row;
        for (std::size_t band = 0; band < kBandNames.size(); ++band) ++bands_[band].histogram[pixel[band]];
      }
      if (in_row == 0) continue;
      pixels_ += in_row;
      const double lat_deg = geo::LatLonFromMerc({0.0, top_m - (row + 0.5) * pixel_m_}).lat_deg;
      covered_m2_ += static_cast<double>(in_row) * pixel_m_ * pixel_m_ * geo::GroundPerMercArea(lat_deg);
    }
    return {};
  }

  void Tell(StatisticsJson& json) const {
    json["covered_m2"] = covered_m2_;
    json["pixels"] = pixels_;
    json["bands"] = StatisticsJson::array();
    for (std::size_t band = 0; band < kBandNames.size(); ++band)
      json["bands"].push_back(bands_[band].Told(pixels_, kBandNames[band]));
  }

 private:
  const storage::Tileset& tileset_;
  const int side_px_;
  const double pixel_m_;
  const storage::BoundaryOnZoom mask_;
  std::vector<std::uint8_t> inside_;
  std::array<BandCount, kBandNames.size()> bands_;
  std::int64_t pixels_ = 0;
  double covered_m2_ = 0.0;
};

// The values of an index within a polygon.
class IndexCounter {
 public:
  IndexCounter(MapBands& map_bands, const storage::Tileset& tileset, const storage::Boundary& boundary,
               int zoom, const IndexLook& look)
      : map_bands_(map_bands),
        tileset_(tileset),
        look_(look),
        side_px_(TileSizePx(tileset)),
        mask_(boundary, zoom, side_px_) {}

  Result<void> Add(const geo::TileId& tile) {
    if (mask_.Mask(tile, inside_) == storage::Cover::kNone) return {};
    SKYQUILT_TRY_ASSIGN(const IndexValues found,
                        ValuesOfTile(map_bands_, tileset_, look_.expression, tile, side_px_));
    for (std::size_t i = 0; i < found.values.size(); ++i) {
      if (inside_[i] != 0 && found.alphas[i] >= kSolidMapAlpha) values_.push_back(found.values[i]);
    }
    return {};
  }

  // Takes the values.
  StatisticsJson Told() {
    const indices::ValueSummary summary = indices::Summarise(std::move(values_));
    StatisticsJson told = {{"title", look_.title}, {"expression", look_.text}, {"pixels", summary.count}};
    for (const char* name : {"min", "max", "mean", "std"}) told[name] = nullptr;
    told["percentiles"] = StatisticsJson::object();
    for (std::size_t i = 0; i < summary.kPercents.size(); ++i) {
      auto& percentile = told["percentiles"][fmt::format("p{}", indices::ValueSummary::kPercents[i])];
      if (summary.count > 0) percentile = summary.percentiles[i];
    }
    if (summary.count > 0) {
      told["min"] = summary.min;
      told["max"] = summary.max;
      told["mean"] = summary.mean;
      told["std"] = summary.std;
    }
    told["histogram"] = summary.histogram;
    return told;
  }

 private:
  MapBands& map_bands_;
  const storage::Tileset& tileset_;
  const IndexLook& look_;
  const int side_px_;
  const storage::BoundaryOnZoom mask_;
  std::vector<std::uint8_t> inside_;
  std::vector<float> values_;
};

// How many pixels are looked at, as the request has it.
Result<double> PixelsWanted(const Request& request) {
  const auto text = request.Query("max_pixels");
  if (!text) return kMaxPixels;
  SKYQUILT_TRY_ASSIGN(const double wanted, NumberParameter(request, "max_pixels"));
  if (wanted >= kMinPixels && wanted <= kMaxPixels) return wanted;
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("The parameter \"max_pixels\" is a number from {} to {}.", kMinPixels, kMaxPixels)};
}

// `polygon`: GeoJSON (storage/exports/custom/boundary). JSON text.
Result<std::string> MapStatistics(Service& service, const std::string& flight_id, std::string_view polygon,
                                  const std::optional<IndexLook>& look, double max_pixels) {
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY(CheckJsonText(polygon));
  SKYQUILT_TRY_ASSIGN(const storage::Boundary boundary, storage::ParseArea(polygon));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight_id));
  const storage::Revision& revision = tileset->revision;
  const std::optional<geo::Bounds2> common = CommonInMerc(boundary, revision);
  const int side_px = TileSizePx(*tileset);
  int zoom = revision.max_zoom;
  if (common) {
    const double area = (common->max.x() - common->min.x()) * (common->max.y() - common->min.y());
    while (zoom > revision.min_zoom && area / std::pow(geo::PixelSizeInMercM(zoom, side_px), 2) > max_pixels)
      --zoom;
  }
  StatisticsCounter counter(*tileset, boundary, zoom);
  std::optional<IndexCounter> of_index;
  if (look) {
    SKYQUILT_TRY(CheckBands(service.bands, *tileset, look->expression));
    of_index.emplace(service.bands, *tileset, boundary, zoom, *look);
  }
  if (common) {
    // Across the antimeridian columns go on at the other end.
    const std::int64_t around = std::int64_t{1} << zoom;
    const auto column_at = [&](double x_m) {
      return static_cast<std::int64_t>(std::floor((x_m + geo::kMercHalfWidthM) / geo::TileSizeInMercM(zoom)));
    };
    const std::int64_t west = std::max<std::int64_t>(column_at(common->min.x()), 0),
                       east = std::min(column_at(common->max.x()), west + around - 1);
    const std::int64_t north = geo::TileId::AtMerc(zoom, {0.0, common->max.y()}).y(),
                       south = geo::TileId::AtMerc(zoom, {0.0, common->min.y()}).y();
    for (std::int64_t y = north; y <= south; ++y) {
      for (std::int64_t x = west; x <= east; ++x) {
        SKYQUILT_TRY_ASSIGN(const geo::TileId tile, geo::TileId::Make(zoom, x % around, y));
        SKYQUILT_TRY(counter.Add(tile));
        if (of_index) SKYQUILT_TRY(of_index->Add(tile));
      }
    }
  }
  StatisticsJson json;
  json["revision"] = revision.revision;
  json["zoom"] = zoom;
  json["pixel_m"] = geo::PixelSizeInMercM(zoom, side_px) *
                    geo::GroundMetresPerMercMetre(boundary.Bounds().Middle().lat_deg);
  json["area_m2"] = geo::AreaM2(boundary);
  counter.Tell(json);
  if (of_index) json["index"] = of_index->Told();
  return JsonText(json);
}

}  // namespace

void AddStatisticsRoute(Router& router, Service& service) {
  AddGeoJsonRoute(router, "/api/v1/flights/{flight}/statistics", "polygon",
                  [&service](const Request& request) -> Result<GeoJsonAnswer> {
                    SKYQUILT_TRY_ASSIGN(const std::optional<IndexLook> look, LookIn(request));
                    SKYQUILT_TRY_ASSIGN(const double pixels, PixelsWanted(request));
                    return GeoJsonAnswer([&service, flight = request.Parameter("flight"), look,
                                          pixels](const std::string& body) {
                      return MapStatistics(service, flight, body, look, pixels);
                    });
                  });
}

}  // namespace skyquilt::api
