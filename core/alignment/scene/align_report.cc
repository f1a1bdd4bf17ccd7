#include "core/alignment/scene/align_report.h"

#include "core/base/check.h"

namespace skyquilt::alignment {
std::string_view FaultName(PhotoFault fault) {
  switch (fault) {
    case PhotoFault::kPositionWrong:
      return "position_wrong";
    case PhotoFault::kYawWrong:
      return "yaw_wrong";
    case PhotoFault::kStoredTurned:
      return "stored_turned";
    case PhotoFault::kCopy:
      return "copy";
    case PhotoFault::kBlurred:
      return "blurred";
    case PhotoFault::kOtherPlace:
      return "other_place";
    case PhotoFault::kFarAway:
      return "far_away";
  }
  SKYQUILT_CHECK(false, "every fault has a name");
  return {};
}

}  // namespace skyquilt::alignment
