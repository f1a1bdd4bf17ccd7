#include "core/alignment/stages/align_options.h"

#include <fmt/core.h>

#include "core/alignment/scene/matches.h"

namespace skyquilt::alignment {

FeatureOptions AlignOptions::Features() const {
  FeatureOptions features;
  features.detector_pixels = detector_pixels;
  features.max_features = max_features;
  return features;
}

Result<void> AlignOptions::Validate() const {
  if (threads < 0) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("threads is {}; it must be 0 or more", threads),
                 ""};
  }
  if (detector_pixels < 20'000) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("detector_pixels is {}; it must be at least 20000", detector_pixels), ""};
  }
  if (max_features < 100 || max_features > kMaxKeypoints || observations_per_photo < 20) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format(
            "max_features is {} and observations_per_photo {}; they must be at least 100 and 20, and the former "
            "at most {}",
            max_features, observations_per_photo, kMaxKeypoints),
        ""};
  }
  return {};
}

}  // namespace skyquilt::alignment
