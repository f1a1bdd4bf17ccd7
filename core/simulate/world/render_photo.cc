#include "core/simulate/world/render_photo.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <ratio>
#include <vector>

#include "core/base/check.h"
#include "core/base/parallel_for.h"
#include "core/simulate/world/random.h"

namespace skyquilt::simulate {
namespace {

constexpr double kFarthestM = 4000.0;
constexpr int kRowsPerBatch = 32;
constexpr int kFineSide = 3;
constexpr double kMotionPerSamplePx = 1.5;  // further apart, the samples of a blurred picture show one by one
constexpr int kMaxSide = 12;
const Eigen::Vector3f kSky(188.0f, 208.0f, 232.0f);

struct SubSample {
  double dx_px, dy_px;
  Eigen::Vector3d shift_in_enu_m;
};

// Regular places in the pixel; each at its own moment of the exposure, in an order without pattern.
std::vector<SubSample> MakeSubSamples(const RenderPhotoOptions& options, int side) {
  const int count = side * side;
  std::vector<SubSample> samples;
  // Steps of about the golden section that meet every moment once.
  int step = static_cast<int>(0.618 * count) + 1;
  while (std::gcd(step, count) != 1) ++step;
  for (int i = 0; i < count; ++i) {
    const int moment = i * step % count;
    const int column = i % side, row = i / side;
    samples.push_back({(column + 0.5) / side - 0.5, (row + 0.5) / side - 0.5,
                       ((moment + 0.5) / count - 0.5) * options.motion_in_enu_m});
  }
  return samples;
}

// One photo in the making: everything that is the same for all its pixels.
class PhotoRenderer {
 public:
  PhotoRenderer(const World& world, const camera::Intrinsics& intrinsics, const geo::Rigid3& cam_from_enu,
                const RenderPhotoOptions& options)
      : world_(world),
        intrinsics_(intrinsics),
        options_(options),
        center_(cam_from_enu.TargetOriginInSource()),
        enu_from_cam_(cam_from_enu.rotation.conjugate().toRotationMatrix()),
        half_diagonal_px_(0.5 * std::hypot(intrinsics.width_px, intrinsics.height_px)) {
    const bool moves = options.motion_in_enu_m.squaredNorm() > 0.0;
    // One sample on bare ground, whose texture is filtered to the pixel already; more at edges and in motion.
    is_adaptive_ = !moves && world.HasUprights();
    plain_ = MakeSubSamples(options, moves ? SideOfMoving() : 1);
    fine_ = MakeSubSamples(options, kFineSide);
  }

  // Rows [begin, end) into `rgb`, the whole image's pixels.
  void RenderRows(int begin, int end, std::uint8_t* rgb) const {
    SampleRows(begin, end, [&](int x, int y, const Eigen::Vector3f& color) {
      const double dx = x - intrinsics_.center_x_px;
      const double dy = y - intrinsics_.center_y_px;
      const double r2 = (dx * dx + dy * dy) / (half_diagonal_px_ * half_diagonal_px_);
      const auto light =
          static_cast<float>(options_.exposure_gain * (1.0 - options_.vignetting * r2) * HotSpot(x, y));
      std::uint8_t* out = rgb + 3 * PixelAt(x, y);
      for (int c = 0; c < 3; ++c) {
        float value = light * color[c];
        if (options_.noise_counts > 0.0) {
          value += static_cast<float>(options_.noise_counts) * SensorNoise(x, y, c, options_.noise_seed);
        }
        out[c] = static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f));
      }
    });
  }

  // The same of a band, into `light`.
  void RenderLightOfRows(int begin, int end, const Eigen::Vector4f& of_color, float* light) const {
    SampleRows(begin, end, [&](int x, int y, const Eigen::Vector3f& color) {
      light[PixelAt(x, y)] = of_color[0] + of_color.tail<3>().dot(color);
    });
  }

 private:
  std::ptrdiff_t PixelAt(int x, int y) const {
    return static_cast<std::ptrdiff_t>(y) * intrinsics_.width_px + x;
  }

  // put(x, y, color) for each pixel of these rows.
  template <typename Put>
  void SampleRows(int begin, int end, const Put& put) const {
    const std::vector<std::uint32_t> surfaces =
        is_adaptive_ ? SurfacesOfRows(begin - 1, end + 1) : std::vector<std::uint32_t>{};
    for (int y = begin; y < end; ++y) {
      double hint_m = 0.0;
      for (int x = 0; x < intrinsics_.width_px; ++x) {
        const bool is_edge = is_adaptive_ && IsEdge(surfaces, x, y - begin + 1);
        put(x, y, Sampled(x, y, is_edge ? fine_ : plain_, hint_m));
      }
    }
  }

  // The form of Maignan, Breon and Lacaze (2004).
  double HotSpot(int x, int y) const {
    if (options_.hot_spot == 0.0) return 1.0;
    double length = 1.0;
    const double phase_rad =
        std::acos(std::clamp(-DirectionOf(x, y, length).dot(options_.sun_in_enu), -1.0, 1.0));
    return 1.0 + options_.hot_spot / (1.0 + phase_rad / options_.hot_spot_rad);
  }

  // Of a picture taken in motion over the level ground: enough samples to draw a streak, not copies.
  int SideOfMoving() const {
    const double motion_px =
        options_.motion_in_enu_m.norm() * intrinsics_.MeanFocalPx() / std::max(1.0, center_.z());
    return std::clamp(static_cast<int>(std::ceil(std::sqrt(motion_px / kMotionPerSamplePx))), kFineSide,
                      kMaxSide);
  }

  Eigen::Vector3d CenterAt(double y) const {
    return center_ + camera::RowShare(y, intrinsics_.height_px) * options_.readout_motion.shift_in_enu_m;
  }

  Eigen::Vector3d DirectionOf(double x, double y, double& length) const {
    const Eigen::Vector3d ray_in_cam = intrinsics_.Unproject({x, y});
    length = ray_in_cam.norm();
    if (options_.readout_motion.turns_rad.empty()) return enu_from_cam_ * (ray_in_cam / length);
    const double share = camera::RowShare(y, intrinsics_.height_px);
    return enu_from_cam_ * (options_.readout_motion.TurnAt(share).conjugate() * (ray_in_cam / length));
  }

  // The mean of a pixel's samples; hint_m is the distance of the last hit, for the next.
  Eigen::Vector3f Sampled(int x, int y, const std::vector<SubSample>& samples, double& hint_m) const {
    // One sample must filter the whole pixel; of several each filters its own part, a little wider.
    const double side = std::sqrt(static_cast<double>(samples.size()));
    const double radians_per_px = (samples.size() == 1 ? 1.0 : 1.3 / side) / intrinsics_.MeanFocalPx();
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const SubSample& sample : samples) {
      double length = 1.0;
      const Eigen::Vector3d direction = DirectionOf(x + sample.dx_px, y + sample.dy_px, length);
      const std::optional<RayHit> hit =
          world_.CastRay(CenterAt(y + sample.dy_px) + sample.shift_in_enu_m, direction, kFarthestM, hint_m);
      if (!hit) {
        sum += kSky;
        continue;
      }
      hint_m = hit->surface == SurfaceKind::kGround ? hit->distance_m : 0.0;
      // Side of a square as large as the pixel's slanting patch: across t/f/length, along that over the
      // cosine.
      const double steepness = std::max(0.05, -direction.z());
      const double footprint_m = hit->distance_m * radians_per_px / (length * std::sqrt(steepness));
      sum += world_.ColorOfHit(*hit, static_cast<float>(footprint_m));
    }
    return sum / static_cast<float>(samples.size());
  }

  // Which surface the middle of each pixel of rows [begin, end) sees.
  std::vector<std::uint32_t> SurfacesOfRows(int begin, int end) const {
    std::vector<std::uint32_t> surfaces;
    for (int y = begin; y < end; ++y) {
      double hint_m = 0.0;
      for (int x = 0; x < intrinsics_.width_px; ++x) {
        double length = 1.0;
        const Eigen::Vector3d direction = DirectionOf(x, y, length);
        const std::optional<RayHit> hit = world_.CastRay(CenterAt(y), direction, kFarthestM, hint_m);
        surfaces.push_back(hit ? hit->building * 4u + static_cast<std::uint32_t>(hit->surface) : 3u);
        hint_m = hit && hit->surface == SurfaceKind::kGround ? hit->distance_m : 0.0;
      }
    }
    return surfaces;
  }
  bool IsEdge(const std::vector<std::uint32_t>& surfaces, int x, int row) const {
    const int width = intrinsics_.width_px;
    const auto at = [&](int column, int line) {
      return surfaces[static_cast<std::size_t>(line) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(std::clamp(column, 0, width - 1))];
    };
    const std::uint32_t own = at(x, row);
    return at(x - 1, row) != own || at(x + 1, row) != own || at(x, row - 1) != own || at(x, row + 1) != own;
  }

  const World& world_;
  const camera::Intrinsics& intrinsics_;
  const RenderPhotoOptions& options_;
  Eigen::Vector3d center_;
  Eigen::Matrix3d enu_from_cam_;
  double half_diagonal_px_;
  bool is_adaptive_ = false;
  std::vector<SubSample> plain_, fine_;
};

// The batches do not depend on the number of threads, and no row depends on the one before.
template <typename Render>
void RenderInBatches(int height_px, int threads, const Render& render) {
  const int batches = (height_px + kRowsPerBatch - 1) / kRowsPerBatch;
  ParallelFor(static_cast<std::size_t>(batches), threads, [&](std::size_t batch) {
    const int begin = static_cast<int>(batch) * kRowsPerBatch;
    render(begin, std::min(height_px, begin + kRowsPerBatch));
  });
}

}  // namespace

// From the pixel's own hash: four uniform bytes summed.
float SensorNoise(int x, int y, int channel, std::uint32_t seed) {
  const std::uint32_t h = HashCell(x * 3 + channel, y, seed);
  const int sum = static_cast<int>((h & 255u) + ((h >> 8) & 255u) + ((h >> 16) & 255u) + (h >> 24)) - 510;
  return static_cast<float>(sum) * (1.0f / 147.8f);  // the sum's 1-sigma
}

image::FloatImage RenderLight(const World& world, const camera::Intrinsics& intrinsics,
                              const geo::Rigid3& cam_from_enu, const Eigen::Vector4f& of_color, int threads) {
  image::FloatImage light{intrinsics.width_px, intrinsics.height_px, {}};
  light.values.resize(static_cast<std::size_t>(light.width_px) * static_cast<std::size_t>(light.height_px));
  const RenderPhotoOptions plain{};  // must outlive the renderer
  const PhotoRenderer renderer(world, intrinsics, cam_from_enu, plain);
  RenderInBatches(light.height_px, threads, [&](int begin, int end) {
    renderer.RenderLightOfRows(begin, end, of_color, light.values.data());
  });
  return light;
}

image::DecodedImage RenderPhoto(const World& world, const camera::Intrinsics& intrinsics,
                                const geo::Rigid3& cam_from_enu, const RenderPhotoOptions& options) {
  SKYQUILT_CHECK(intrinsics.width_px > 0 && intrinsics.height_px > 0 && intrinsics.focal_x_px > 0.0,
                 "a simulated camera needs a size and a focal length");
  image::DecodedImage image;
  image.width_px = intrinsics.width_px;
  image.height_px = intrinsics.height_px;
  image.rgb.resize(static_cast<std::size_t>(image.width_px) * static_cast<std::size_t>(image.height_px) * 3);
  const PhotoRenderer renderer(world, intrinsics, cam_from_enu, options);
  RenderInBatches(image.height_px, options.threads,
                  [&](int begin, int end) { renderer.RenderRows(begin, end, image.rgb.data()); });
  return image;
}

Eigen::Vector3d SunDirection(const geo::LatLon& place, std::chrono::sys_time<std::chrono::microseconds> utc) {
  constexpr std::chrono::sys_seconds kJ2000{std::chrono::seconds(946'728'000)};  // 2000-01-01 12:00
  const double days = std::chrono::duration<double, std::ratio<86'400>>(utc - kJ2000).count();
  const double mean_longitude_deg = 280.460 + 0.985'647'4 * days;
  const double anomaly_rad = geo::DegToRad(357.528 + 0.985'600'3 * days);
  const double ecliptic_longitude_rad =
      geo::DegToRad(mean_longitude_deg + 1.915 * std::sin(anomaly_rad) + 0.020 * std::sin(2.0 * anomaly_rad));
  const double obliquity_rad = geo::DegToRad(23.439 - 4e-7 * days);
  const double right_ascension_rad = std::atan2(std::cos(obliquity_rad) * std::sin(ecliptic_longitude_rad),
                                                std::cos(ecliptic_longitude_rad));
  const double declination_rad = std::asin(std::sin(obliquity_rad) * std::sin(ecliptic_longitude_rad));
  const double sidereal_deg = 15.0 * (18.697'374'558 + 24.065'709'824'419'08 * days) + place.lon_deg;
  const double hour_angle_rad = geo::DegToRad(sidereal_deg) - right_ascension_rad;
  const double lat_rad = geo::DegToRad(place.lat_deg);
  const double sin_dec = std::sin(declination_rad), cos_dec = std::cos(declination_rad);
  return {-cos_dec * std::sin(hour_angle_rad),
          sin_dec * std::cos(lat_rad) - cos_dec * std::cos(hour_angle_rad) * std::sin(lat_rad),
          sin_dec * std::sin(lat_rad) + cos_dec * std::cos(hour_angle_rad) * std::cos(lat_rad)};
}

}  // namespace skyquilt::simulate
