#include "core/render/bands/measure_targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "core/bands/find_panel.h"
#include "core/bands/radiometry.h"
#include "core/base/median.h"
#include "core/camera/rolling_shutter.h"
#include "core/render/bands/band_cache.h"

namespace skyquilt::render {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMaxCaptures = 6;
constexpr int kSamplesAcross = 17;
constexpr double kMaxSpread = 0.25;  // of the middle half, as a share of the median: more is no even target

// Points of the target on the ground, evenly spread.
std::vector<Vector3d> PointsOf(const flight::GroundTarget& target, const geo::LocalFrame& frame,
                               const ground::GroundSurface& ground) {
  Vector3d center = frame.EnuAtHeight(target.center, ground.MeanHeight());
  center = frame.EnuAtHeight(target.center, ground.HeightAt(center.head<2>()));
  std::vector<Vector3d> points;
  for (int row = 0; row < kSamplesAcross; ++row) {
    for (int column = 0; column < kSamplesAcross; ++column) {
      const Eigen::Vector2d offset =
          target.radius_m *
          (2.0 * Eigen::Vector2d(column, row) / (kSamplesAcross - 1) - Eigen::Vector2d::Ones());
      if (offset.norm() > target.radius_m) continue;
      const Eigen::Vector2d at = center.head<2>() + offset;
      points.emplace_back(at.x(), at.y(), ground.HeightAt(at));
    }
  }
  return points;
}

// What one picture shows of the target; nothing where it does not show all of it.
struct LookedAt {
  double value = 0.0;
  double spread = 0.0;
  bool is_clipped = false;
};
std::optional<LookedAt> Look(const std::vector<Vector3d>& points, const BandCamera& camera,
                             const image::SampleImage& picture) {
  const image::FloatImage shown = bands::ValuesOf(picture, camera.radiometry);
  std::vector<double> values;
  std::size_t clipped = 0;
  for (const Vector3d& point : points) {
    const auto pixel = camera::ProjectRolling(camera.photo.intrinsics, camera.photo.cam_from_enu,
                                              camera.photo.readout_motion, point);
    if (!pixel) return std::nullopt;
    const Eigen::Vector2d at = *pixel + camera.field.At(*pixel);
    const float value = ValueAt(shown, static_cast<float>(at.x()), static_cast<float>(at.y()));
    if (std::isnan(value)) return std::nullopt;
    values.push_back(value);
    const auto nearest =
        static_cast<std::size_t>(std::lround(at.y()) * picture.width_px + std::lround(at.x()));
    clipped += picture.samples[nearest] >= bands::kClippedLevel ? 1 : 0;
  }
  std::sort(values.begin(), values.end());
  const double median = values[values.size() / 2];
  if (!(median > 0.0)) return std::nullopt;
  return LookedAt{
      median, (values[values.size() * 3 / 4] - values[values.size() / 4]) / median,
      static_cast<double>(clipped) > bands::kMaxClippedShare * static_cast<double>(values.size())};
}

// Captures, the one nearest above the target first.
std::vector<std::size_t> NearestFirst(const alignment::AlignedFlight& references, const Vector3d& center) {
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (std::size_t i = 0; i < references.photos.size(); ++i) {
    const Vector3d camera = references.photos[i].cam_from_enu.TargetOriginInSource();
    by_distance.emplace_back((camera - center).head<2>().norm(), i);
  }
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<std::size_t> order;
  for (const auto& [distance, i] : by_distance) order.push_back(i);
  return order;
}

bool SeesAll(const std::vector<Vector3d>& points, const BandCamera& camera) {
  const camera::Intrinsics& lens = camera.photo.intrinsics;
  return std::all_of(points.begin(), points.end(), [&](const Vector3d& point) {
    const auto pixel = lens.Project(camera.photo.cam_from_enu * point);
    return pixel && pixel->x() >= 0.0 && pixel->y() >= 0.0 && pixel->x() <= lens.width_px - 1 &&
           pixel->y() <= lens.height_px - 1;
  });
}

}  // namespace

TargetFactors MeasureTargets(const alignment::AlignedFlight& references, const ground::GroundSurface& ground,
                             const bands::Captures& captures, const BandCameras& cameras,
                             const flight::PhotoSource& source) {
  TargetFactors factors;
  factors.by_band.resize(captures.bands.size());
  for (std::size_t t = 0; t < captures.targets.size(); ++t) {
    const flight::GroundTarget& target = captures.targets[t];
    const std::vector<Vector3d> points = PointsOf(target, references.frame, ground);
    const std::vector<std::size_t> order = NearestFirst(references, points[points.size() / 2]);
    bool is_seen = false, is_even = true;
    std::vector<std::string> overexposed;  // bands
    for (std::size_t band = 0; band < captures.bands.size(); ++band) {
      const auto reflectance = bands::ReflectanceOf(target.reflectance, captures.bands[band].name);
      const bands::Calibration calibration = captures.bands[band].calibration;
      if (!reflectance || calibration == bands::Calibration::kKelvin ||
          calibration == bands::Calibration::kLevels)
        continue;
      std::vector<double> values, spreads;
      std::size_t clipped = 0;  // captures
      for (const std::size_t i : order) {
        const std::optional<BandCamera>& camera = cameras.captures[i].cameras[band];
        if (!camera || values.size() + clipped == kMaxCaptures || !SeesAll(points, *camera)) continue;
        const auto picture = source.DecodeSamples(camera->photo.photo);
        const auto shown = picture ? Look(points, *camera, *picture) : std::nullopt;
        if (!shown) continue;
        if (shown->is_clipped) {
          ++clipped;
          continue;
        }
        values.push_back(shown->value);
        spreads.push_back(shown->spread);
      }
      if (values.empty() && clipped > 0) overexposed.push_back(captures.bands[band].name);
      if (values.empty()) continue;
      is_seen = true;
      is_even = is_even && Median(spreads) <= kMaxSpread;
      factors.by_band[band].push_back(*reflectance / Median(values));
    }
    if (!overexposed.empty()) {
      factors.warnings.push_back(
          {flight::RemarkCode::kTargetOverexposed,
           {{"target", t + 1}, {"bands", fmt::format("{}", fmt::join(overexposed, ", "))}}});
    }
    if (!is_seen && overexposed.empty()) {
      factors.warnings.push_back({flight::RemarkCode::kTargetUnseen, {{"target", t + 1}}});
    } else if (!is_even) {
      factors.warnings.push_back({flight::RemarkCode::kTargetUneven,
                                  {{"target", t + 1}, {"file", std::string(flight::kReflectanceListName)}}});
    }
  }
  return factors;
}

}  // namespace skyquilt::render
