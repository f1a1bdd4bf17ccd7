// The line whose heights somebody asks for.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "api/flights/heights.h"
#include "core/base/check.h"
#include "core/pipeline/report/ground_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt;
  const auto line = api::ParseLine({reinterpret_cast<const char*>(bytes), size});
  if (!line) {
    SKYQUILT_CHECK(!line.error().message.empty(), "a refusal without a word");
    return 0;
  }
  SKYQUILT_CHECK(line->size() >= 2 && line->size() <= pipeline::kMaxProfileCorners,
                 "not as many as are taken");
  const auto profile = pipeline::ProfileGround({}, {-180.0, -90.0, 180.0, 90.0}, *line);
  if (!profile) return 0;
  SKYQUILT_CHECK(profile->samples.size() <= pipeline::kMaxProfileSamples + 2 * pipeline::kMaxProfileCorners,
                 "more samples than are bounded");
  for (const pipeline::ProfileSample& sample : profile->samples)
    SKYQUILT_CHECK(std::isfinite(sample.distance_m), "a distance that is none");
  return 0;
}
