#include "core/pipeline/report/ground_choice.h"

namespace skyquilt::pipeline {
namespace {

constexpr double kMinLeaningShare = 0.05, kMinSeenShare = 0.5;

}  // namespace

bool IsUpright(const GroundChoice& choice) {
  return choice.leaning_share >= kMinLeaningShare && choice.seen_share >= kMinSeenShare;
}

}  // namespace skyquilt::pipeline
