#include "core/poses/evidence/assumption.h"

#include <utility>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::poses {

using flight::InARow;
using flight::Remark;
using flight::RemarkCode;

std::vector<Remark> AssumptionsByPoses(const std::vector<Assumption>& assumptions) {
  std::vector<Remark> remarks;
  for (const Assumption& one : assumptions) remarks.push_back(InARow({one.missing, one.assumed}));
  return remarks;
}

std::vector<Remark> AssumptionsAfterAlignment(const std::vector<Assumption>& assumptions,
                                              double found_height_m, int by_pose) {
  std::vector<Remark> remarks;
  for (const Assumption& one : assumptions) {
    Remark found = RemarkCode::kAnglesFound;
    if (one.height_above_ground_m) {
      found = {RemarkCode::kHeightFound,
               {{"assumed_m", *one.height_above_ground_m}, {"found_m", found_height_m}}};
    }
    Remark said = InARow({one.missing, std::move(found)});
    if (by_pose > 0) {
      const Remark by_poses(RemarkCode::kAssumedByPoses, {{"photos", by_pose}, {"assumed", one.assumed}});
      said = InARow({std::move(said), by_poses});
    }
    remarks.push_back(std::move(said));
  }
  return remarks;
}

}  // namespace skyquilt::poses
