#include "core/flight/photo.h"

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
  switch (source) {
    case FocalSource::kDewarpData:
      return "dewarp_data";
    case FocalSource::kCalibrated:
      return "calibrated_focal_length";
    case FocalSource::kXmpCamera:
      return "xmp_camera";
    case FocalSource::kFocalPlane:
      return "focal_plane_resolution";
    case FocalSource::kSensorTable:
      return "sensor_table";
    case FocalSource::k35mmEquivalent:
      return "35mm_equivalent";
    case FocalSource::kDoubtful:
      return "doubtful";
    case FocalSource::kAssumed:
      return "assumed";
  }
  return "unknown";
}

}  // namespace skyquilt::flight
