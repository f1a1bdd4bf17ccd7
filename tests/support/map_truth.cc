#include "tests/support/map_truth.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/geo/raster_frame.h"
#include "core/simulate/world/world_raster.h"

namespace skyquilt::test {
namespace {

cv::Mat1f Smoothed(const cv::Mat& rgb, int code) {
  cv::Mat grey;
  cv::cvtColor(rgb, grey, code);
  cv::Mat1f out;
  grey.convertTo(out, CV_32F);
  cv::GaussianBlur(out, out, {5, 5}, 1.2);
  return out;
}

}  // namespace

MapError MeasureMapError(const MemorySink& map, const simulate::World& world, const geo::LocalFrame& frame) {
  constexpr int kPatch = 64;
  constexpr double kMinTexture = 1.0;  // mean squared gradient
  const int finest = map.tiles.rbegin()->first.z();
  MapError error;
  double sum = 0.0;
  for (const auto& [tile, stored] : map.tiles) {
    if (tile.z() != finest || stored.format != image::PictureFormat::kJpeg) continue;
    const cv::Mat bgr = cv::imdecode(stored.bytes, cv::IMREAD_COLOR);
    const image::DecodedImage truth =
        simulate::RenderWorld(world, frame, geo::RasterFrame::OfTile(tile, bgr.cols));
    const cv::Mat truth_rgb(truth.height_px, truth.width_px, CV_8UC3,
                            const_cast<std::uint8_t*>(truth.rgb.data()));
    const cv::Mat1f a = Smoothed(bgr, cv::COLOR_BGR2GRAY);
    const cv::Mat1f b = Smoothed(truth_rgb, cv::COLOR_RGB2GRAY);
    for (int y = 0; y + kPatch <= a.rows; y += kPatch) {
      for (int x = 0; x + kPatch <= a.cols; x += kPatch) {
        // One linear least-squares step for the shift s in a(p) = b(p - s) + brightness.
        cv::Matx33d normal = cv::Matx33d::zeros();
        cv::Vec3d right(0, 0, 0);
        for (int v = y + 3; v < y + kPatch - 3; ++v) {
          for (int u = x + 3; u < x + kPatch - 3; ++u) {
            const cv::Vec3d row(0.5 * (b(v, u + 1) - b(v, u - 1)), 0.5 * (b(v + 1, u) - b(v - 1, u)), 1.0);
            normal += row * row.t();
            right += row * static_cast<double>(a(v, u) - b(v, u));
          }
        }
        const double pixels = (kPatch - 6.0) * (kPatch - 6.0);
        if (std::min(normal(0, 0), normal(1, 1)) / pixels < kMinTexture) continue;
        const cv::Vec3d solved = normal.solve(right, cv::DECOMP_SVD);
        const double shift = std::hypot(solved[0], solved[1]);
        ++error.patches;
        sum += shift * shift;
        error.worst_shift_px = std::max(error.worst_shift_px, shift);
        error.mean_east_px -= solved[0];
        error.mean_south_px -= solved[1];
      }
    }
  }
  if (error.patches > 0) {
    error.shift_rmse_px = std::sqrt(sum / error.patches);
    error.mean_east_px /= error.patches;
    error.mean_south_px /= error.patches;
  }
  return error;
}

}  // namespace skyquilt::test
