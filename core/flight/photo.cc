#include "core/flight/photo.h"

namespace skyquilt::flight {

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
    case FocalSource::kAssumed:
      return "assumed";
  }
  return "unknown";
}

}  // namespace skyquilt::flight
