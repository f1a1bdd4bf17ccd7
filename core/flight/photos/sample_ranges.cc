#include "core/flight/photos/sample_ranges.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "core/base/parallel_for.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kPicturesLookedAt = 16;

// The depth of a sensor whose levels reach `high`.
SampleRange RangeOfDepth(double high) {
  for (const double levels : {1024.0, 4096.0, 16384.0}) {
    if (high < levels) return {0.0, levels};
  }
  return {};
}

}  // namespace

std::optional<SampleRange> RangeOf(std::vector<float> values, SampleKind kind) {
  std::erase_if(values, [](float value) { return !std::isfinite(value); });
  if (values.empty()) return std::nullopt;
  constexpr std::size_t kRareShare = 1000;
  const auto rare = static_cast<std::ptrdiff_t>(values.size() / kRareShare);
  std::nth_element(values.begin(), values.begin() + rare, values.end());
  const double low = values[static_cast<std::size_t>(rare)];
  std::nth_element(values.begin() + rare, values.end() - 1 - rare, values.end());
  const double high = *(values.end() - 1 - rare);
  if (kind == SampleKind::kColourLevels) return RangeOfDepth(high);
  constexpr double kNarrow = 4096.0;
  if (kind == SampleKind::kLevels) {
    if (high - low < 1.0) return SampleRange{};
    if (high - low >= kNarrow) return RangeOfDepth(high);
  }
  if (!(high > low)) return SampleRange{low - 1.0, low + 1.0};
  return SampleRange{low, high};
}

void ChooseSampleRanges(std::vector<Photo>& photos, const PhotoSource& source, int threads) {
  std::map<std::pair<std::string, SampleKind>, std::vector<std::size_t>> cameras;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (photos[i].sample_kind != SampleKind::kBytes && !photos[i].sample_range)
      cameras[{photos[i].camera_key, photos[i].sample_kind}].push_back(i);
  }
  for (const auto& [camera, of_camera] : cameras) {
    const std::vector<std::size_t>& own = of_camera;  // a binding may not be captured by every compiler
    const std::size_t count = std::min(kPicturesLookedAt, own.size());
    std::vector<std::vector<float>> found(count);
    ParallelFor(count, threads, [&](std::size_t k) {
      // From the first to the last of the flight.
      const std::size_t photo = own[count == 1 ? 0 : k * (own.size() - 1) / (count - 1)];
      if (Result<std::vector<float>> values = source.SampleValues(photos[photo], kSampleValues))
        found[k] = *std::move(values);
    });
    std::vector<float> all;
    for (const std::vector<float>& values : found) all.insert(all.end(), values.begin(), values.end());
    const std::optional<SampleRange> range = RangeOf(std::move(all), camera.second);
    for (const std::size_t i : of_camera) photos[i].sample_range = range;
  }
}

}  // namespace skyquilt::flight
