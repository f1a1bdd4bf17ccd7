// The ports of the core: what it needs from outside, as interfaces. The only pipeline header that every stage
// may include. Implementations live in core/flight (photo files) and storage (tiles).
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "core/base/pixel_bytes.h"
#include "core/base/result.h"
#include "core/flight/photo.h"
#include "core/geo/lat_lon.h"
#include "core/geo/tile_id.h"

namespace skyquilt::pipeline {

// 8-bit RGB, rows without padding, first row on top, as the sensor stored it (EXIF orientation not applied:
// the recorded angles belong to the sensor).
struct DecodedImage {
  int width_px = 0;
  int height_px = 0;
  PixelBytes rgb;

  const std::uint8_t* Row(int y) const { return rgb.data() + static_cast<std::size_t>(y) * width_px * 3; }
};

// Pixels from left to right - 1 and from top to bottom - 1; none where those are less.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;

  bool IsEmpty() const { return right <= left || bottom <= top; }
  bool Contains(const PixelBox& other) const {
    return left <= other.left && top <= other.top && right >= other.right && bottom >= other.bottom;
  }
  // The smallest around both.
  PixelBox With(const PixelBox& other) const {
    if (IsEmpty()) return other;
    if (other.IsEmpty()) return *this;
    return {std::min(left, other.left), std::min(top, other.top), std::max(right, other.right),
            std::max(bottom, other.bottom)};
  }
  PixelBox Within(const PixelBox& other) const {
    return {std::max(left, other.left), std::max(top, other.top), std::min(right, other.right),
            std::min(bottom, other.bottom)};
  }
  PixelBox Grown(int by) const { return {left - by, top - by, right + by, bottom + by}; }
};

// A rectangle of a picture.
struct DecodedPart {
  DecodedImage image;
  int left_px = 0, top_px = 0;  // of the picture's pixels, where it begins
};

class PhotoSource {
 public:
  virtual ~PhotoSource() = default;
  // Decodes at 1/denominator of the size (1, 2, 4 or 8; sides rounded up). Any number of threads at a time.
  // Errors: kCorrupt (damaged or cut off), kUnsupportedFormat, kIo.
  virtual Result<DecodedImage> Decode(const flight::Photo& photo, int denominator) const = 0;
  // At least those pixels of what Decode gives; damage elsewhere may go unnoticed. `memory` is of no use to the
  // caller any more: whoever can makes the picture in it, which saves the machine's fetching more.
  virtual Result<DecodedPart> DecodePart(const flight::Photo& photo, int denominator, const PixelBox& /*box*/,
                                         PixelBytes /*memory*/) const {
    Result<DecodedImage> whole = Decode(photo, denominator);
    if (!whole) return whole.error();
    return DecodedPart{*std::move(whole)};
  }
};

// Heights of the ground, above whatever zero the model has: only differences and, where the model counts from
// sea level, absolute heights make sense.
class DemSource {
 public:
  virtual ~DemSource() = default;
  // Nothing outside the model or where it has a hole. One thread at a time.
  virtual std::optional<double> GroundHeightM(const geo::LatLon& position) const = 0;
};

enum class TileFormat { kJpeg, kPng, kWebp };

class TileSink {
 public:
  virtual ~TileSink() = default;
  // Takes one encoded tile. Called by one thread at a time, in an order that does not depend on threads.
  virtual Result<void> Put(const geo::TileId& tile, TileFormat format,
                           std::span<const std::uint8_t> bytes) = 0;
};

}  // namespace skyquilt::pipeline
