// The ports of the core: what it needs from outside, as interfaces. The only pipeline header that every stage
// may include. Implementations live in core/flight (photo files) and storage (tiles).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

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

class PhotoSource {
 public:
  virtual ~PhotoSource() = default;
  // Decodes at 1/denominator of the size (1, 2, 4 or 8; sides rounded up). Any number of threads at a time.
  // Errors: kCorrupt (damaged or cut off), kUnsupportedFormat, kIo.
  virtual Result<DecodedImage> Decode(const flight::Photo& photo, int denominator) const = 0;
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
