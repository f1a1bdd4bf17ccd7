#include "core/alignment/stages/align_options.h"

#include <fmt/core.h>

#include <string>
#include <utility>

#include "core/alignment/scene/matches.h"

namespace skyquilt::alignment {

FeatureOptions AlignOptions::Features() const {
  return {.detector_pixels = detector_pixels, .max_features = max_features};
}

Result<void> AlignOptions::Validate() const {
  const auto refuse = [](std::string why) { return Error{ErrorCode::kInvalidArgument, std::move(why), ""}; };
  if (threads < 0) return refuse(fmt::format("threads is {}; it must be 0 or more", threads));
  if (detector_pixels < 20'000)
    return refuse(fmt::format("detector_pixels is {}; it must be at least 20000", detector_pixels));
  if (max_features < 100 || max_features > kMaxKeypoints || observations_per_photo < 20) {
    return refuse(fmt::format(
        "max_features is {} and observations_per_photo {}; they must be at least 100 and 20, and the former "
        "at most {}",
        max_features, observations_per_photo, kMaxKeypoints));
  }
  return {};
}

}  // namespace skyquilt::alignment
