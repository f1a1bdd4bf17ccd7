#include "core/render/exposure/exposure_samples.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "core/base/median.h"
#include "core/camera/footprint.h"
#include "core/camera/rolling_shutter.h"
#include "core/render/exposure/exposure.h"

namespace skyquilt::render {
namespace {

// About this many spots across a photo: enough to see a hot spot, and of thousands of photos, which see it
// often enough, enough for a gain.
double SpotsAcross(std::size_t photos) {
  constexpr double kMax = 28.0, kMin = 14.0, kPhotos = 100.0;
  return std::clamp(kMax * std::sqrt(kPhotos / static_cast<double>(photos)), kMin, kMax);
}
constexpr float kDarkest = 12.0f;
constexpr float kBrightest = 246.0f;

// A photo that reaches further than so many times what one sees straight down, from high above or towards the
// horizon, is asked at every second spot, every fourth and so on: others are asked there too.
constexpr double kMaxReach = 4.3;

// Half the side of the patch whose mean is taken, as a share of the thumbnail's width.
constexpr double kHalfPatchShare = 1.0 / 128.0;

// Mean colour of a small patch around a full-size pixel; nothing near the border or where it is clipped.
std::optional<std::array<float, 3>> Colour(const image::DecodedImage& thumbnail,
                                           const camera::Intrinsics& lens, const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>((pixel.x() + 0.5) * thumbnail.width_px / lens.width_px);
  const int y = static_cast<int>((pixel.y() + 0.5) * thumbnail.height_px / lens.height_px);
  const int half = std::max(1, static_cast<int>(thumbnail.width_px * kHalfPatchShare));
  if (x < half || y < half || x + half >= thumbnail.width_px || y + half >= thumbnail.height_px)
    return std::nullopt;
  std::array<float, 3> sum{};
  for (int dy = -half; dy <= half; ++dy) {
    for (int dx = -half; dx <= half; ++dx) {
      const std::size_t k = (static_cast<std::size_t>(y + dy) * thumbnail.width_px + (x + dx)) * 3;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += thumbnail.rgb[k + c];
    }
  }
  for (float& value : sum) {
    value /= static_cast<float>((2 * half + 1) * (2 * half + 1));
    if (value < kDarkest || value > kBrightest) return std::nullopt;
    value = std::log(value);
  }
  return sum;
}

}  // namespace

std::vector<ExposureSample> SampleExposure(const alignment::AlignedFlight& flight,
                                           const ground::GroundSurface& ground,
                                           const std::vector<Thumbnail>& thumbnails) {
  std::vector<ExposureSample> samples;
  if (flight.photos.size() < 2) return samples;
  const double size_m = MedianOf(flight.photos, [](const alignment::AlignedPhoto& photo) {
    return photo.height_above_ground_m / photo.intrinsics.MeanFocalPx() *
           std::max(photo.intrinsics.width_px, photo.intrinsics.height_px);
  });
  const double spots_across = SpotsAcross(flight.photos.size());
  const double step_m = std::max(0.1, size_m / spots_across);

  std::unordered_map<std::int64_t, std::uint32_t> spot_of_cell;
  for (std::uint32_t i = 0; i < flight.photos.size(); ++i) {
    const alignment::AlignedPhoto& photo = flight.photos[i];
    const geo::Bounds2 bounds = camera::BoundsOf(camera::GroundFootprint(
        photo.intrinsics, photo.cam_from_enu, ground.MeanHeight(), 8, photo.max_look_rad));
    if (bounds.IsEmpty()) continue;
    const double reach_m = std::max(bounds.Width(), bounds.Height());
    std::int64_t stride = 1;
    while (reach_m > kMaxReach * spots_across * step_m * static_cast<double>(stride)) stride *= 2;
    const double stride_m = step_m * static_cast<double>(stride);
    const image::DecodedImage thumbnail = Decode(thumbnails[i]);
    const double half_diagonal_px = 0.5 * std::hypot(photo.intrinsics.width_px, photo.intrinsics.height_px);
    const Eigen::Vector2d image_center_px{photo.intrinsics.center_x_px, photo.intrinsics.center_y_px};
    const Eigen::Vector3d camera_in_enu = photo.cam_from_enu.TargetOriginInSource();
    for (auto row = static_cast<std::int64_t>(std::floor(bounds.min.y() / stride_m)) * stride;
         row * step_m <= bounds.max.y(); row += stride) {
      for (auto column = static_cast<std::int64_t>(std::floor(bounds.min.x() / stride_m)) * stride;
           column * step_m <= bounds.max.x(); column += stride) {
        const Eigen::Vector2d spot{column * step_m, row * step_m};
        const double ground_z_m = ground.HeightAt(spot);
        const auto pixel = camera::ProjectRolling(photo.intrinsics, photo.cam_from_enu, photo.readout_motion,
                                                  {spot.x(), spot.y(), ground_z_m});
        if (!pixel || !photo.intrinsics.IsInImage(*pixel)) continue;
        const auto colour = Colour(thumbnail, photo.intrinsics, *pixel);
        if (!colour) continue;
        const std::int64_t cell = (row << 32) ^ (column & 0xffffffff);
        const auto number =
            spot_of_cell.try_emplace(cell, static_cast<std::uint32_t>(spot_of_cell.size())).first->second;
        const Eigen::Vector2f place = ((*pixel - image_center_px) / half_diagonal_px).cast<float>();
        const Eigen::Vector2f look =
            LookOf(Eigen::Vector3d(spot.x(), spot.y(), ground_z_m) - camera_in_enu).cast<float>();
        const Eigen::Vector2f on_ground = spot.cast<float>();
        samples.push_back({number,
                           i,
                           {on_ground.x(), on_ground.y()},
                           {place.x(), place.y()},
                           {look.x(), look.y()},
                           *colour});
      }
    }
  }
  std::sort(samples.begin(), samples.end(), [](const ExposureSample& a, const ExposureSample& b) {
    return a.spot != b.spot ? a.spot < b.spot : a.photo < b.photo;
  });
  std::vector<ExposureSample> shared;
  for (std::size_t begin = 0; begin < samples.size();) {
    const std::size_t end = EndOfSpot(samples, begin);
    if (end - begin >= 2)
      shared.insert(shared.end(), samples.begin() + static_cast<std::ptrdiff_t>(begin),
                    samples.begin() + static_cast<std::ptrdiff_t>(end));
    begin = end;
  }
  return shared;
}

std::size_t EndOfSpot(const std::vector<ExposureSample>& samples, std::size_t begin) {
  std::size_t end = begin;
  while (end < samples.size() && samples[end].spot == samples[begin].spot) ++end;
  return end;
}

}  // namespace skyquilt::render
