#include "core/surface/views/gray_photos.h"

#include <algorithm>
#include <utility>

#include "core/base/trace.h"
#include "core/base/vector_clones.h"

namespace skyquilt::surface {
namespace {

// A cell may be so many pixels of the picture that it is sampled from: beyond, samples skip pixels.
constexpr double kMaxPixelsInCell = 1.45;
constexpr int kMinSidePx = 16;

void FillGray(const std::uint8_t* rgb, std::size_t count, std::uint8_t* gray) {
  for (std::size_t i = 0; i < count; ++i, rgb += 3) {
    gray[i] = static_cast<std::uint8_t>((77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2] + 128) >> 8);
  }
}

SKYQUILT_VECTOR_CLONES void HalveGrayRows(const std::uint8_t* upper, const std::uint8_t* lower, int count,
                                          std::uint8_t* half) {
  for (int i = 0; i < count; ++i) {
    half[i] = static_cast<std::uint8_t>(
        (upper[2 * i] + upper[2 * i + 1] + lower[2 * i] + lower[2 * i + 1] + 2) >> 2);
  }
}

GrayPicture HalfOf(const GrayPicture& picture) {
  GrayPicture half{picture.width_px / 2, picture.height_px / 2, {}};
  half.gray.resize(static_cast<std::size_t>(half.width_px) * half.height_px);
  for (int y = 0; y < half.height_px; ++y) {
    const std::uint8_t* upper = picture.gray.data() + static_cast<std::size_t>(2 * y) * picture.width_px;
    HalveGrayRows(upper, upper + picture.width_px, half.width_px,
                  half.gray.data() + static_cast<std::size_t>(y) * half.width_px);
  }
  return half;
}

}  // namespace

int GrayDenominator(double cell_in_photo_px) {
  int denominator = 1;
  while (denominator < 8 && cell_in_photo_px / denominator > kMaxPixelsInCell) denominator *= 2;
  return denominator;
}

std::size_t GrayPyramid::LevelFor(double cell_in_photo_px) const {
  std::size_t level = 0;
  double cell_px = cell_in_photo_px / denominator;
  for (; level + 1 < pictures.size() && cell_px > kMaxPixelsInCell; ++level) cell_px *= 0.5;
  return level;
}

GrayPhotos::GrayPhotos(const flight::PhotoSource& source, int levels, std::int64_t budget_bytes)
    : source_(source), levels_(levels), budget_bytes_(budget_bytes) {}

GrayPhotos::Shared GrayPhotos::Decode(const flight::Photo& photo, int denominator) const {
  const TraceSpan span("decode for heights", photo.name);
  Result<image::DecodedImage> decoded = source_.Decode(photo, denominator);
  if (!decoded || decoded->width_px < kMinSidePx || decoded->height_px < kMinSidePx) return nullptr;
  auto pyramid = std::make_shared<GrayPyramid>();
  pyramid->denominator = denominator;
  GrayPicture first{decoded->width_px, decoded->height_px, {}};
  first.gray.resize(static_cast<std::size_t>(first.width_px) * first.height_px);
  FillGray(decoded->rgb.data(), first.gray.size(), first.gray.data());
  pyramid->pictures.push_back(std::move(first));
  for (int level = 1; level < levels_; ++level) {
    const GrayPicture& last = pyramid->pictures.back();
    if (std::min(last.width_px, last.height_px) < 2 * kMinSidePx) break;
    pyramid->pictures.push_back(HalfOf(last));
  }
  return pyramid;
}

GrayPhotos::Shared GrayPhotos::Get(std::size_t photo_index, const flight::Photo& photo, int denominator) {
  std::promise<Shared> promise;
  std::shared_future<Shared> waited_for;
  {
    std::lock_guard lock(mutex_);
    const auto [found, is_new] = entries_.try_emplace(photo_index);
    Entry& entry = found->second;
    if (is_new) {
      entry.pyramid = promise.get_future().share();
      recency_.push_front(photo_index);
      entry.recency = recency_.begin();
    } else {
      recency_.splice(recency_.begin(), recency_, entry.recency);
      waited_for = entry.pyramid;
    }
  }
  if (waited_for.valid()) return waited_for.get();
  Shared pyramid;
  try {
    pyramid = Decode(photo, denominator);
  } catch (...) {
    promise.set_exception(std::current_exception());
    throw;
  }
  promise.set_value(pyramid);
  std::lock_guard lock(mutex_);
  Entry& entry = entries_.at(photo_index);
  entry.bytes = 1;  // what is no picture is remembered too
  if (pyramid) {
    for (const GrayPicture& picture : pyramid->pictures) {
      entry.bytes += static_cast<std::int64_t>(picture.gray.size());
    }
  }
  held_bytes_ += entry.bytes;
  EvictOld();
  return pyramid;
}

void GrayPhotos::EvictOld() {
  auto it = recency_.end();
  while (held_bytes_ > budget_bytes_ && it != recency_.begin()) {
    const auto oldest = std::prev(it);
    const auto entry = entries_.find(*oldest);
    if (entry->second.bytes == 0) {  // still decoded
      it = oldest;
      continue;
    }
    held_bytes_ -= entry->second.bytes;
    entries_.erase(entry);
    it = recency_.erase(oldest);
  }
}

}  // namespace skyquilt::surface
