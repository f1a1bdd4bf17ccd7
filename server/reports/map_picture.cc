#include "server/reports/map_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <system_error>

#include "core/base/try.h"
#include "core/geo/lat_lon.h"
#include "core/image/picture_codec.h"
#include "storage/exports/custom/export_map.h"
#include "storage/exports/thumbnail_writer.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::server {
namespace {

constexpr float kPictureQuality = 82.0F;

double LongerSideM(const geo::LatLonBounds& bounds) {
  const double height_m = geo::DegToRad(bounds.north_deg - bounds.south_deg) * geo::kWgs84SemiMajorM;
  const double width_m = geo::DegToRad(bounds.east_deg - bounds.west_deg) * geo::kWgs84SemiMajorM *
                         std::cos(geo::DegToRad(bounds.Middle().lat_deg));
  return std::max(height_m, width_m);
}

}  // namespace

Result<MapPixels> MakeMapPixels(const std::filesystem::path& map, int longer_side_px, int threads,
                                const std::filesystem::path& work_folder, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(storage::ExportSource source, storage::ExportSourceOf(map));
  SKYQUILT_TRY_ASSIGN(const auto reader, storage::MbtilesReader::Open(source.mbtiles));
  SKYQUILT_TRY_ASSIGN(const storage::MapFacts facts, storage::FactsOfTileset(reader->metadata()));
  source.is_placed = true;  // a picture has a scale wherever the map lies; the page says what it is worth
  MapPixels pixels;
  pixels.pixel_m = std::max(facts.FinestPixelM(), LongerSideM(facts.bounds) / longer_side_px);
  storage::ExportRequest request;
  request.resolution_m = pixels.pixel_m;
  const std::filesystem::path tif = work_folder / "picture.tif", png = work_folder / "picture.png";
  const storage::ExportOptions options{.threads = threads};
  SKYQUILT_TRY(storage::ExportMap(source, request, work_folder, tif, options, progress));
  SKYQUILT_TRY(storage::WriteThumbnail(tif, png, image::kMaxPictureSidePx));
  SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::ReadWholeFile(png));
  SKYQUILT_TRY_ASSIGN(pixels.image, image::DecodePicture(bytes));
  std::error_code stays;  // the folder's owner removes what is left
  std::filesystem::remove(tif, stays);
  std::filesystem::remove(png, stays);
  return pixels;
}

MapPicture EncodeMapPicture(const MapPixels& pixels) {
  return {image::EncodeWebp(image::RowsOf(pixels.image), kPictureQuality), pixels.image.width_px,
          pixels.image.height_px, pixels.pixel_m};
}

std::string ToBytes(const MapPixels& pixels) {
  std::string bytes =
      fmt::format("{} {} {:.17g}\n", pixels.image.width_px, pixels.image.height_px, pixels.pixel_m);
  bytes.append(reinterpret_cast<const char*>(pixels.image.rgba.data()), pixels.image.rgba.size());
  return bytes;
}

Result<MapPixels> ParseMapPixels(std::string_view bytes) {
  constexpr std::size_t kMaxHeadBytes = 100;
  const std::size_t end = bytes.substr(0, kMaxHeadBytes).find('\n');
  MapPixels pixels;
  int width_px = 0, height_px = 0;
  if (end != std::string_view::npos) {
    const std::string head(bytes.substr(0, end));
    const std::string_view rgba = bytes.substr(end + 1);
    const auto is_side = [](int side) { return side > 0 && side <= image::kMaxPictureSidePx; };
    if (std::sscanf(head.c_str(), "%d %d %lf", &width_px, &height_px, &pixels.pixel_m) == 3 &&
        is_side(width_px) && is_side(height_px) && std::isfinite(pixels.pixel_m) && pixels.pixel_m > 0.0 &&
        rgba.size() ==
            std::size_t{4} * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)) {
      pixels.image.width_px = width_px;
      pixels.image.height_px = height_px;
      pixels.image.rgba.assign(rgba.begin(), rgba.end());
      return pixels;
    }
  }
  return Error{ErrorCode::kCorrupt, "The report's picture of the map is damaged."};
}

double ScaleBarM(double most_m) {
  if (!(most_m > 0.0) || !std::isfinite(most_m)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(most_m)));
  for (const double times : {5.0, 2.0}) {
    if (times * power <= most_m) return times * power;
  }
  return power;
}

}  // namespace skyquilt::server
