#include "core/simulate/world/world_raster.h"

#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "core/base/parallel_for.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::simulate {
namespace {

constexpr int kBlockPx = 32;  // between exact positions, which are interpolated (error below a micrometre)
constexpr int kEdgeSide = 3;  // samples a pixel, a side
constexpr double kUpperM = 100.0;  // of the second plane: the ellipsoid's vertical against the frame's

struct Corner {
  Eigen::Vector2d east_north;   // on the plane z = 0
  Eigen::Vector2d shift_per_m;  // of E, N with height
  double height_ellipsoid_m;    // of that plane
};

Corner CornerAt(const geo::LocalFrame& frame, const geo::RasterFrame& raster, double x, double y) {
  const geo::LatLon position = geo::LatLonFromMerc(raster.MercFromPixel({x, y}));
  const Eigen::Vector3d low = frame.EnuAtHeight(position, 0.0);
  const Eigen::Vector2d high = frame.EnuAtHeight(position, kUpperM).head<2>();
  return {low.head<2>(), (high - low.head<2>()) / kUpperM, frame.Wgs84FromEnu(low).height_ellipsoid_m};
}

struct PlaceOfPixel {
  Eigen::Vector2d east_north;  // where its vertical meets the surface
  float footprint_m;
  double plane_height_ellipsoid_m;  // of z = 0 there
};

// put(place, i) for each pixel, i by rows.
template <typename Put>
void ForEachPixel(const World& world, const geo::LocalFrame& frame, const geo::RasterFrame& raster,
                  const Put& put) {
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
          const double plane_m = (1.0 - v) * std::lerp(nw.height_ellipsoid_m, ne.height_ellipsoid_m, u) +
                                 v * std::lerp(sw.height_ellipsoid_m, se.height_ellipsoid_m, u);
          put(PlaceOfPixel{flat + world.SurfaceHeightAt(flat.x(), flat.y()) * nw.shift_per_m, footprint_m,
                           plane_m},
              static_cast<std::size_t>(y) * static_cast<std::size_t>(raster.width_px) +
                  static_cast<std::size_t>(x));
        }
      }
    }
  }
}

// The mean over the pixel where the edge of an object crosses it; elsewhere colours are filtered already.
Eigen::Vector3f ColorOfPixel(const World& world, const PlaceOfPixel& place) {
  const Eigen::Vector2d& at = place.east_north;
  if (!world.objects().empty()) {
    const double half_m = 0.5 * place.footprint_m;
    const int here = world.ObjectAt(at.x() - half_m, at.y() - half_m);
    if (world.ObjectAt(at.x() + half_m, at.y() - half_m) != here ||
        world.ObjectAt(at.x() - half_m, at.y() + half_m) != here ||
        world.ObjectAt(at.x() + half_m, at.y() + half_m) != here) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      const double step_m = static_cast<double>(place.footprint_m) / kEdgeSide;
      for (int i = 0; i < kEdgeSide * kEdgeSide; ++i) {
        const int right = i % kEdgeSide - kEdgeSide / 2, up = i / kEdgeSide - kEdgeSide / 2;
        const double east = at.x() + step_m * right;
        const double north = at.y() + step_m * up;
        sum += world.ColorAt(east, north, static_cast<float>(1.3 * step_m));
      }
      return sum / static_cast<float>(kEdgeSide * kEdgeSide);
    }
  }
  return world.ColorAt(at.x(), at.y(), place.footprint_m);
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

// Of three samples a pixel.
template <typename Sample>
void SetTags(TIFF* tiff, const geo::RasterFrame& raster) {
  constexpr bool kIsColor = std::is_same_v<Sample, std::uint8_t>;
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(raster.width_px));
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(raster.height_px));
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sizeof(Sample)));
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kIsColor ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  if (!kIsColor) {
    const std::uint16_t others[] = {EXTRASAMPLE_UNSPECIFIED, EXTRASAMPLE_UNSPECIFIED};
    TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 2, others);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  }
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kWorldTilePx);
  TIFFSetField(tiff, TIFFTAG_TILELENGTH, kWorldTilePx);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(tiff, TIFFTAG_PREDICTOR, kIsColor ? PREDICTOR_HORIZONTAL : PREDICTOR_FLOATINGPOINT);
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

// Tile by tile; `samples_of` makes three of each pixel of one.
template <typename Samples, typename SamplesOf>
Result<void> WriteTiles(const geo::RasterFrame& raster, int threads, const std::filesystem::path& path,
                        const char* what, Progress& progress, const SamplesOf& samples_of) {
  using Sample = typename Samples::value_type;
  // Above 2 GB the file may pass the 4 GiB that a plain TIFF can address.
  const double bytes = 3.0 * sizeof(Sample) * raster.width_px * raster.height_px;
  const std::unique_ptr<TIFF, void (*)(TIFF*)> tiff(TIFFOpen(path.c_str(), bytes > 2e9 ? "w8" : "w"),
                                                    TIFFClose);
  if (!tiff) return WriteFailed(path);
  RegisterGeoTags(tiff.get());
  SetTags<Sample>(tiff.get(), raster);
  const int columns = raster.width_px / kWorldTilePx;
  const int rows = raster.height_px / kWorldTilePx;
  const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  bool failed = false;
  ParallelOrdered<Samples>(
      count, threads, 4 * static_cast<std::size_t>(ThreadCount(threads)),
      [&](std::size_t i) {
        if (progress.IsCancelled()) return Samples{};
        geo::RasterFrame tile = raster;
        const double side_m = raster.pixel_size_in_merc_m * kWorldTilePx;
        const std::size_t column = i % static_cast<std::size_t>(columns);
        const std::size_t row = i / static_cast<std::size_t>(columns);
        tile.north_west_in_merc +=
            Eigen::Vector2d(side_m * static_cast<double>(column), -side_m * static_cast<double>(row));
        tile.width_px = tile.height_px = kWorldTilePx;
        return samples_of(tile);
      },
      [&](std::size_t i, Samples&& samples) {
        if (failed || samples.empty()) return;
        failed = TIFFWriteEncodedTile(tiff.get(), static_cast<std::uint32_t>(i), samples.data(),
                                      static_cast<tmsize_t>(sizeof(Sample) * samples.size())) < 0;
        progress.Report(static_cast<double>(i + 1) / static_cast<double>(count), what);
      });
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The simulation was cancelled.", ""};
  if (failed || TIFFFlush(tiff.get()) == 0) return WriteFailed(path);
  return {};
}

}  // namespace

// The grid goes on beyond the antimeridian, as tiles do not.
geo::RasterFrame WorldRasterFrame(const geo::Bounds2& bounds_in_merc, int zoom) {
  const double tile_m = geo::TileSizeInMercM(zoom);
  const double west = std::floor((bounds_in_merc.min.x() + geo::kMercHalfWidthM) / tile_m),
               east = std::floor((bounds_in_merc.max.x() + geo::kMercHalfWidthM) / tile_m),
               north = std::floor((geo::kMercHalfWidthM - bounds_in_merc.max.y()) / tile_m),
               south = std::floor((geo::kMercHalfWidthM - bounds_in_merc.min.y()) / tile_m);
  return {{west * tile_m - geo::kMercHalfWidthM, geo::kMercHalfWidthM - north * tile_m},
          tile_m / kWorldTilePx,
          static_cast<int>(east - west + 1.0) * kWorldTilePx,
          static_cast<int>(south - north + 1.0) * kWorldTilePx};
}

image::DecodedImage RenderWorld(const World& world, const geo::LocalFrame& frame,
                                const geo::RasterFrame& raster) {
  image::DecodedImage image;
  image.width_px = raster.width_px;
  image.height_px = raster.height_px;
  image.rgb.resize(static_cast<std::size_t>(raster.width_px) * static_cast<std::size_t>(raster.height_px) *
                   3);
  ForEachPixel(world, frame, raster, [&](const PlaceOfPixel& place, std::size_t i) {
    PutColor(ColorOfPixel(world, place), image.rgb.data() + 3 * i);
  });
  return image;
}

std::vector<float> SurfaceOf(const World& world, const geo::LocalFrame& frame,
                             const geo::RasterFrame& raster) {
  std::vector<float> samples(static_cast<std::size_t>(raster.width_px) *
                             static_cast<std::size_t>(raster.height_px) * 3);
  ForEachPixel(world, frame, raster, [&](const PlaceOfPixel& place, std::size_t i) {
    const double east = place.east_north.x(), north = place.east_north.y();
    samples[3 * i] = static_cast<float>(place.plane_height_ellipsoid_m + world.SurfaceHeightAt(east, north));
    samples[3 * i + 1] =
        static_cast<float>(place.plane_height_ellipsoid_m + world.TerrainHeightAt(east, north));
    const int object = world.ObjectAt(east, north);
    samples[3 * i + 2] = static_cast<float>(object < 0 && world.IsWaterAt(east, north) ? -1 : object + 1);
  });
  return samples;
}

Result<void> WriteWorldGeoTiff(const World& world, const geo::LocalFrame& frame,
                               const geo::RasterFrame& raster, int threads, const std::filesystem::path& path,
                               Progress& progress) {
  return WriteTiles<PixelBytes>(
      raster, threads, path, "truth map", progress,
      [&](const geo::RasterFrame& tile) { return RenderWorld(world, frame, tile).rgb; });
}

Result<void> WriteSurfaceGeoTiff(const World& world, const geo::LocalFrame& frame,
                                 const geo::RasterFrame& raster, int threads,
                                 const std::filesystem::path& path, Progress& progress) {
  return WriteTiles<std::vector<float>>(
      raster, threads, path, "true heights", progress,
      [&](const geo::RasterFrame& tile) { return SurfaceOf(world, frame, tile); });
}

}  // namespace skyquilt::simulate
