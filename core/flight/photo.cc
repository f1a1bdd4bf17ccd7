#include "core/flight/photo.h"

#include <array>
#include <tuple>

namespace skyquilt::flight {

std::string MakeAndModel(const Photo& photo) {
  return photo.model.starts_with(photo.make) ? photo.model : photo.make + " " + photo.model;
}

bool ComesBefore(const Photo& a, const Photo& b) {
  if (a.captured_at.has_value() != b.captured_at.has_value()) return a.captured_at.has_value();
  return std::tie(a.captured_at, a.name) < std::tie(b.captured_at, b.name);
}

const char* FocalSourceName(FocalSource source) {
  constexpr std::array kNames = {
      "dewarp_data",  "calibrated_focal_length", "xmp_camera", "focal_plane_resolution",
      "sensor_table", "35mm_equivalent",         "doubtful",   "assumed"};
  static_assert(kNames.size() == static_cast<std::size_t>(FocalSource::kAssumed) + 1);
  return kNames[static_cast<std::size_t>(source)];
}

}  // namespace skyquilt::flight
