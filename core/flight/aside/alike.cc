#include "core/flight/aside/alike.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::flight {
namespace {

double AspectOf(const Photo& photo) {
  const auto [shorter, longer] = std::minmax(photo.intrinsics.width_px, photo.intrinsics.height_px);
  return static_cast<double>(longer) / std::max(shorter, 1);
}

}  // namespace

double PhotoPixels(const Photo& photo) {
  return static_cast<double>(photo.intrinsics.width_px) * photo.intrinsics.height_px;
}

bool AreNear(double a, double b, double share) { return std::abs(a - b) <= share * std::max(a, b); }

bool SeeAlike(const Photo& a, const Photo& b) {
  constexpr double kSameView = 0.1;
  if (a.focal_source == FocalSource::kAssumed || b.focal_source == FocalSource::kAssumed) return true;
  const auto focal = [](const Photo& photo) {
    return photo.intrinsics.MeanFocalPx() /
           std::max({photo.intrinsics.width_px, photo.intrinsics.height_px, 1});
  };
  return AreNear(focal(a), focal(b), kSameView);
}

bool IsReducedTo(const Photo& copy, const Photo& original) {
  constexpr double kSameAspect = 0.02;
  return PhotoPixels(copy) < PhotoPixels(original) &&
         AreNear(AspectOf(copy), AspectOf(original), kSameAspect) && SeeAlike(copy, original);
}

bool AreOfTwoSensors(const Photo& a, const Photo& b) {
  return (a.lens == Lens::kThermal) != (b.lens == Lens::kThermal) || a.band_name != b.band_name;
}

}  // namespace skyquilt::flight
