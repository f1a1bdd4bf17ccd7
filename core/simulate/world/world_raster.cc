#include "core/simulate/world/world_raster.h"

#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/parallel_for.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::simulate {
namespace {

constexpr int kBlockPx = 32;  // between exact positions, which are interpolated (error below a micrometre)
constexpr double kUpperM = 100.0;  // of the second plane: the ellipsoid's vertical against the frame's

struct Corner {
  Eigen::Vector2d east_north;   // on the plane z = 0
  Eigen::Vector2d shift_per_m;  // of E, N with height
};

Corner CornerAt(const geo::LocalFrame& frame, const geo::RasterFrame& raster, double x, double y) {
  const geo::LatLon position = geo::LatLonFromMerc(raster.MercFromPixel({x, y}));
  const Eigen::Vector2d low = frame.EnuAtHeight(position, 0.0).head<2>();
  const Eigen::Vector2d high = frame.EnuAtHeight(position, kUpperM).head<2>();
  return {low, (high - low) / kUpperM};
}

void PutColor(const Eigen::Vector3f& color, std::uint8_t* out) {
  for (int c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>(std::clamp(color[c] + 0.5f, 0.0f, 255.0f));
}

// GeoTIFF tags (OGC 19-008r4), unknown to libtiff until it is told.
void RegisterGeoTags(TIFF* tiff) {
  static const TIFFFieldInfo kFields[] = {
      {33550, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, const_cast<char*>("ModelPixelScaleTag")},
      {33922, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, const_cast<char*>("ModelTiepointTag")},
      {34735, -1, -1, TIFF_SHORT, FIELD_CUSTOM, 1, 1, const_cast<char*>("GeoKeyDirectoryTag")},
  };
  TIFFMergeFieldInfo(tiff, kFields, 3);
}

void SetTags(TIFF* tiff, const geo::RasterFrame& raster) {
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(raster.width_px));
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(raster.height_px));
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kWorldTilePx);
  TIFFSetField(tiff, TIFFTAG_TILELENGTH, kWorldTilePx);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(tiff, TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
  TIFFSetField(tiff, TIFFTAG_ZIPQUALITY, 1);
  const double scale[3] = {raster.pixel_size_in_merc_m, raster.pixel_size_in_merc_m, 0.0};
  const double tie[6] = {0.0, 0.0, 0.0, raster.north_west_in_merc.x(), raster.north_west_in_merc.y(), 0.0};
  // Version 1.1.0, four keys: projected model, pixels are areas, EPSG:3857, metres.
  const std::uint16_t keys[] = {1, 1, 0, 4, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 3857, 3076, 0, 1, 9001};
  TIFFSetField(tiff, 33550, 3, scale);
  TIFFSetField(tiff, 33922, 6, tie);
  TIFFSetField(tiff, 34735, static_cast<int>(std::size(keys)), keys);
}

Error WriteFailed(const std::filesystem::path& path) {
  return Error{ErrorCode::kIo,
               "Could not write " + path.string() + ": check that the folder exists and the disk has room.",
               "libtiff failed on " + path.string()};
}

}  // namespace

geo::RasterFrame WorldRasterFrame(const geo::Bounds2& bounds_in_merc, int zoom) {
  const geo::TileId first = geo::TileId::AtMerc(zoom, {bounds_in_merc.min.x(), bounds_in_merc.max.y()});
  const geo::TileId last = geo::TileId::AtMerc(zoom, {bounds_in_merc.max.x(), bounds_in_merc.min.y()});
  geo::RasterFrame raster = geo::RasterFrame::OfTile(first, kWorldTilePx);
  raster.width_px = static_cast<int>(last.x() - first.x() + 1) * kWorldTilePx;
  raster.height_px = static_cast<int>(last.y() - first.y() + 1) * kWorldTilePx;
  return raster;
}

image::DecodedImage RenderWorld(const World& world, const geo::LocalFrame& frame,
                                const geo::RasterFrame& raster) {
  image::DecodedImage image;
  image.width_px = raster.width_px;
  image.height_px = raster.height_px;
  image.rgb.resize(static_cast<std::size_t>(raster.width_px) * static_cast<std::size_t>(raster.height_px) *
                   3);
  for (int y0 = 0; y0 < raster.height_px; y0 += kBlockPx) {
    for (int x0 = 0; x0 < raster.width_px; x0 += kBlockPx) {
      const Corner nw = CornerAt(frame, raster, x0, y0);
      const Corner ne = CornerAt(frame, raster, x0 + kBlockPx, y0);
      const Corner sw = CornerAt(frame, raster, x0, y0 + kBlockPx);
      const Corner se = CornerAt(frame, raster, x0 + kBlockPx, y0 + kBlockPx);
      const auto footprint_m = static_cast<float>((ne.east_north - nw.east_north).norm() / kBlockPx);
      for (int y = y0; y < std::min(y0 + kBlockPx, raster.height_px); ++y) {
        const double v = static_cast<double>(y - y0) / kBlockPx;
        const Eigen::Vector2d west = nw.east_north + v * (sw.east_north - nw.east_north);
        const Eigen::Vector2d east = ne.east_north + v * (se.east_north - ne.east_north);
        for (int x = x0; x < std::min(x0 + kBlockPx, raster.width_px); ++x) {
          const double u = static_cast<double>(x - x0) / kBlockPx;
          const Eigen::Vector2d flat = west + u * (east - west);
          const Eigen::Vector2d at = flat + world.SurfaceHeightAt(flat.x(), flat.y()) * nw.shift_per_m;
          PutColor(
              world.ColorAt(at.x(), at.y(), footprint_m),
              image.rgb.data() + (static_cast<std::size_t>(y) * static_cast<std::size_t>(raster.width_px) +
                                  static_cast<std::size_t>(x)) *
                                     3);
        }
      }
    }
  }
  return image;
}

Result<void> WriteWorldGeoTiff(const World& world, const geo::LocalFrame& frame,
                               const geo::RasterFrame& raster, int threads, const std::filesystem::path& path,
                               Progress& progress) {
  // Above 2 GiB of pixels the file may pass the 4 GiB that a plain TIFF can address.
  const double bytes = 3.0 * raster.width_px * raster.height_px;
  const std::unique_ptr<TIFF, void (*)(TIFF*)> tiff(TIFFOpen(path.c_str(), bytes > 2e9 ? "w8" : "w"),
                                                    TIFFClose);
  if (!tiff) return WriteFailed(path);
  RegisterGeoTags(tiff.get());
  SetTags(tiff.get(), raster);
  const int columns = raster.width_px / kWorldTilePx;
  const int rows = raster.height_px / kWorldTilePx;
  const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  bool failed = false;
  ParallelOrdered<image::DecodedImage>(
      count, threads, 4 * static_cast<std::size_t>(ThreadCount(threads)),
      [&](std::size_t i) {
        if (progress.IsCancelled()) return image::DecodedImage{};
        geo::RasterFrame tile = raster;
        const double side_m = raster.pixel_size_in_merc_m * kWorldTilePx;
        const std::size_t column = i % static_cast<std::size_t>(columns);
        const std::size_t row = i / static_cast<std::size_t>(columns);
        tile.north_west_in_merc +=
            Eigen::Vector2d(side_m * static_cast<double>(column), -side_m * static_cast<double>(row));
        tile.width_px = tile.height_px = kWorldTilePx;
        return RenderWorld(world, frame, tile);
      },
      [&](std::size_t i, image::DecodedImage&& image) {
        if (failed || image.rgb.empty()) return;
        failed = TIFFWriteEncodedTile(tiff.get(), static_cast<std::uint32_t>(i), image.rgb.data(),
                                      static_cast<tmsize_t>(image.rgb.size())) < 0;
        progress.Report(static_cast<double>(i + 1) / static_cast<double>(count), "truth map");
      });
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The simulation was cancelled.", ""};
  if (failed || TIFFFlush(tiff.get()) == 0) return WriteFailed(path);
  return {};
}

}  // namespace skyquilt::simulate
