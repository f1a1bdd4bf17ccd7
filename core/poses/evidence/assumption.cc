#include "core/poses/evidence/assumption.h"

namespace skyquilt::poses {
namespace {

using flight::Remark;
using flight::RemarkCode;

Remark InTurn(Remark first, Remark then) {
  return {RemarkCode::kSentences, {{"first", std::move(first)}, {"then", std::move(then)}}};
}

}  // namespace

std::vector<Remark> AssumptionsByPoses(const std::vector<Assumption>& assumptions) {
  std::vector<Remark> remarks;
  for (const Assumption& one : assumptions) remarks.push_back(InTurn(one.missing, one.assumed));
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
    Remark said = InTurn(one.missing, std::move(found));
    if (by_pose > 0) {
      said = InTurn(std::move(said),
                    {RemarkCode::kAssumedByPoses, {{"photos", by_pose}, {"assumed", one.assumed}}});
    }
    remarks.push_back(std::move(said));
  }
  return remarks;
}

}  // namespace skyquilt::poses
