// GrayPhotos: photos in gray at halves of their size, under a byte budget, least recently used out first. Two
// threads that want the same photo decode it once. Any thread; what Get returned stays valid while it is
// held.
#pragma once

#include <cstdint>
#include <future>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/pixel_bytes.h"
#include "core/flight/photo.h"
#include "core/flight/photos/photo_source.h"

namespace skyquilt::surface {

struct GrayPicture {
  int width_px = 0;
  int height_px = 0;
  PixelBytes gray;  // row by row
};

struct GrayPyramid {
  int denominator = 1;                // of the first picture, against the photo
  std::vector<GrayPicture> pictures;  // each half of the one before

  // The coarsest whose pixels are no larger than about the cells, if a cell spans so many pixels of the
  // photo.
  std::size_t LevelFor(double cell_in_photo_px) const;
};

// The scale (1, 2, 4 or 8) at which to decode a photo for cells of so many of its pixels.
int GrayDenominator(double cell_in_photo_px);

class GrayPhotos {
 public:
  // Each photo comes with `levels` pictures, as far as it is large enough.
  GrayPhotos(const flight::PhotoSource& source, int levels, std::int64_t budget_bytes);

  // Nothing of a photo that cannot be decoded. A photo is asked for with one denominator only.
  std::shared_ptr<const GrayPyramid> Get(std::size_t photo_index, const flight::Photo& photo,
                                         int denominator);

 private:
  using Shared = std::shared_ptr<const GrayPyramid>;
  struct Entry {
    std::shared_future<Shared> pyramid;
    std::int64_t bytes = 0;  // 0 while it is decoded
    std::list<std::size_t>::iterator recency;
  };
  Shared Decode(const flight::Photo& photo, int denominator) const;
  void EvictOld();

  const flight::PhotoSource& source_;
  const int levels_;
  const std::int64_t budget_bytes_;
  std::mutex mutex_;
  std::map<std::size_t, Entry> entries_;
  std::list<std::size_t> recency_;  // most recent first
  std::int64_t held_bytes_ = 0;
};

}  // namespace skyquilt::surface
