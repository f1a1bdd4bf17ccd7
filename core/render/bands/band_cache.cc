#include "core/render/bands/band_cache.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/try.h"

namespace skyquilt::render {
namespace {

image::FloatImage MeansOf(image::FloatImage picture, int denominator) {
  if (denominator == 1) return picture;
  const int width = picture.width_px / denominator, height = picture.height_px / denominator;
  image::FloatImage means{width, height, std::vector<float>(static_cast<std::size_t>(width) * height, 0.0F)};
  for (int y = 0; y < height * denominator; ++y) {
    const float* from = picture.values.data() + static_cast<std::ptrdiff_t>(y) * picture.width_px;
    float* to = means.values.data() + static_cast<std::ptrdiff_t>(y / denominator) * width;
    for (int x = 0; x < width * denominator; ++x) to[x / denominator] += from[x];
  }
  const float share = 1.0F / static_cast<float>(denominator * denominator);
  for (float& value : means.values) value *= share;
  return means;
}

std::array<float, 4> CubicWeights(float t) {
  constexpr float kA = -0.5F;
  const auto near = [&](float d) { return ((kA + 2.0F) * d - (kA + 3.0F)) * d * d + 1.0F; };
  const auto far = [&](float d) { return ((kA * d - 5.0F * kA) * d + 8.0F * kA) * d - 4.0F * kA; };
  return {far(1.0F + t), near(t), near(1.0F - t), far(2.0F - t)};
}

}  // namespace

Result<std::shared_ptr<const image::FloatImage>> BandCache::Get(std::size_t capture, const BandCamera& camera,
                                                                int denominator) {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& entry) { return entry.capture == capture; });
  if (found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front().picture;
  }
  SKYQUILT_TRY_ASSIGN(const image::SampleImage samples, source_.DecodeSamples(camera.photo.photo));
  auto picture = std::make_shared<const image::FloatImage>(
      MeansOf(bands::ValuesOf(samples, camera.radiometry), denominator));
  const auto bytes_of = [](const image::FloatImage& image) {
    return static_cast<std::int64_t>(image.values.size() * sizeof(float));
  };
  held_bytes_ += bytes_of(*picture);
  entries_.push_front({capture, picture});
  while (held_bytes_ > budget_bytes_ && entries_.size() > 1) {
    held_bytes_ -= bytes_of(*entries_.back().picture);
    entries_.pop_back();
  }
  return picture;
}

float ValueAt(const image::FloatImage& picture, float x, float y) {
  const auto width = static_cast<float>(picture.width_px), height = static_cast<float>(picture.height_px);
  if (!(x >= 0.0F && y >= 0.0F && x <= width - 1.0F && y <= height - 1.0F))
    return std::numeric_limits<float>::quiet_NaN();
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const std::array<float, 4> across = CubicWeights(x - static_cast<float>(column));
  const std::array<float, 4> down = CubicWeights(y - static_cast<float>(row));
  float sum = 0.0F;
  for (int j = 0; j < 4; ++j) {
    const int line = std::clamp(row + j - 1, 0, picture.height_px - 1);
    const float* values = picture.values.data() + static_cast<std::ptrdiff_t>(line) * picture.width_px;
    float along = 0.0F;
    for (int i = 0; i < 4; ++i) {
      const int at = std::clamp(column + i - 1, 0, picture.width_px - 1);
      along += across[static_cast<std::size_t>(i)] * values[at];
    }
    sum += down[static_cast<std::size_t>(j)] * along;
  }
  return sum;
}

}  // namespace skyquilt::render
