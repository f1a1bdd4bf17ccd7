// BandCache: the pictures of bands as values, decoded when they are first asked for and dropped oldest first
// beyond a budget. One thread. Errors: those of PhotoSource::DecodeSamples.
#pragma once

#include <cstdint>
#include <list>
#include <memory>

#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/image/decoded_image.h"
#include "core/render/bands/band_cameras.h"

namespace skyquilt::render {

class BandCache {
 public:
  BandCache(const flight::PhotoSource& source, std::int64_t budget_bytes)
      : source_(source), budget_bytes_(budget_bytes) {}

  // At 1/denominator of the size: each value the mean of denominator x denominator pixels; those that hang
  // over the edge are left out.
  Result<std::shared_ptr<const image::FloatImage>> Get(std::size_t capture, const BandCamera& camera,
                                                       int denominator);

 private:
  struct Entry {
    std::size_t capture = 0;
    std::shared_ptr<const image::FloatImage> picture;
  };
  const flight::PhotoSource& source_;
  const std::int64_t budget_bytes_;
  std::list<Entry> entries_;  // most recent first
  std::int64_t held_bytes_ = 0;
};

// Between the values of a picture, bicubic (Keys 1981 with a = -0.5), pixel centres at whole numbers. Not a
// number beyond its outermost centres.
float ValueAt(const image::FloatImage& picture, float x, float y);

}  // namespace skyquilt::render
