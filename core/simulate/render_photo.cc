#include "core/simulate/render_photo.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/check.h"
#include "core/base/parallel_for.h"
#include "core/simulate/noise.h"

namespace skyquilt::simulate {
namespace {

constexpr double kFarthestM = 4000.0;
constexpr std::size_t kRowsPerBatch = 16;
const Eigen::Vector3f kSky(188.0f, 208.0f, 232.0f);

struct SubSample {
  double dx_px, dy_px;
  Eigen::Vector3d shift_in_enu_m;
};

// Regular places in the pixel; each at its own moment of the exposure, in an order without pattern.
std::vector<SubSample> MakeSubSamples(const RenderPhotoOptions& options, int side) {
  const int count = side * side;
  std::vector<SubSample> samples;
  for (int i = 0; i < count; ++i) {
    const int moment = (i * 7 + i / side * 3) % count;
    samples.push_back({((i % side) + 0.5) / side - 0.5, ((i / side) + 0.5) / side - 0.5,
                       ((moment + 0.5) / count - 0.5) * options.motion_in_enu_m});
  }
  return samples;
}

// About Gaussian, from the pixel's own hash: four uniform bytes summed.
float NoiseOf(int x, int y, int channel, std::uint32_t seed) {
  const std::uint32_t h = HashCell(x * 3 + channel, y, seed);
  const int sum = static_cast<int>((h & 255u) + ((h >> 8) & 255u) + ((h >> 16) & 255u) + (h >> 24)) - 510;
  return static_cast<float>(sum) * (1.0f / 147.8f);  // the sum's 1-sigma
}

}  // namespace

pipeline::DecodedImage RenderPhoto(const World& world, const camera::Intrinsics& intrinsics,
                                   const geo::Rigid3& cam_from_enu, const RenderPhotoOptions& options) {
  SKYQUILT_CHECK(intrinsics.width_px > 0 && intrinsics.height_px > 0 && intrinsics.focal_x_px > 0.0,
                 "a simulated camera needs a size and a focal length");
  pipeline::DecodedImage image;
  image.width_px = intrinsics.width_px;
  image.height_px = intrinsics.height_px;
  image.rgb.resize(static_cast<std::size_t>(image.width_px) * static_cast<std::size_t>(image.height_px) * 3);

  const bool moves = options.motion_in_enu_m.squaredNorm() > 0.0;
  const int automatic = moves ? 3 : (world.options().has_boxes ? 2 : 1);
  const int side = options.supersample > 0 ? options.supersample : automatic;
  const std::vector<SubSample> samples = MakeSubSamples(options, side);
  const Eigen::Vector3d center = cam_from_enu.TargetOriginInSource();
  const Eigen::Matrix3d enu_from_cam = cam_from_enu.rotation.conjugate().toRotationMatrix();
  // One sample must filter the whole pixel; of several each filters its own part, a little wider.
  const double pixel_share = side == 1 ? 1.0 : 1.3 / side;
  const double radians_per_px = pixel_share / intrinsics.MeanFocalPx();
  const double half_diagonal_px = 0.5 * std::hypot(intrinsics.width_px, intrinsics.height_px);
  const auto gain = static_cast<float>(options.exposure_gain);
  const auto noise = static_cast<float>(options.noise_counts);

  const auto height = static_cast<std::size_t>(image.height_px);
  const std::size_t batches = (height + kRowsPerBatch - 1) / kRowsPerBatch;
  ParallelFor(batches, options.threads, [&](std::size_t batch) {
    const std::size_t end = std::min(height, (batch + 1) * kRowsPerBatch);
    for (std::size_t row = batch * kRowsPerBatch; row < end; ++row) {
      const int y = static_cast<int>(row);
      std::uint8_t* out = image.rgb.data() + row * static_cast<std::size_t>(image.width_px) * 3;
      for (int x = 0; x < image.width_px; ++x) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (const SubSample& sample : samples) {
          const Eigen::Vector3d ray_in_cam = intrinsics.Unproject({x + sample.dx_px, y + sample.dy_px});
          const double length = ray_in_cam.norm();
          const Eigen::Vector3d direction = enu_from_cam * (ray_in_cam / length);
          const std::optional<RayHit> hit =
              world.CastRay(center + sample.shift_in_enu_m, direction, kFarthestM);
          if (!hit) {
            sum += kSky;
            continue;
          }
          // Side of a square as large as the pixel's slanting patch: across t/f/length, along that over the
          // cosine.
          const double steepness = std::max(0.05, -direction.z());
          const double footprint_m = hit->distance_m * radians_per_px / (length * std::sqrt(steepness));
          sum += world.ColorOfHit(*hit, static_cast<float>(footprint_m));
        }
        const double dx = x - intrinsics.center_x_px;
        const double dy = y - intrinsics.center_y_px;
        const double r2 = (dx * dx + dy * dy) / (half_diagonal_px * half_diagonal_px);
        const float light =
            gain * static_cast<float>(1.0 - options.vignetting * r2) / static_cast<float>(samples.size());
        for (int c = 0; c < 3; ++c) {
          float value = light * sum[c];
          if (noise > 0.0f) value += noise * NoiseOf(x, y, c, options.noise_seed);
          out[3 * x + c] = static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f));
        }
      }
    }
  });
  return image;
}

}  // namespace skyquilt::simulate
