// PhotoCache: decoded photos, or what is wanted of them, under a byte budget, least recently used out first.
// Two threads that want the same of a photo decode it once. Any thread; what Get returned stays valid while
// it is held. Of a photo so large that a few of them would pass the budget no more is decoded at once than
// what is asked for and as much around it as fits.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "core/flight/photo.h"
#include "core/flight/photos/photo_source.h"
#include "core/image/decoded_image.h"

namespace skyquilt::render {

using DecodedPhoto = std::shared_ptr<const image::DecodedPart>;

class PhotoCache {
 public:
  PhotoCache(const flight::PhotoSource& source, std::int64_t budget_bytes);

  // That this part of a photo will be asked for, in pixels of its full size: it is decoded with the first of
  // it that is. A photo of which nothing is expected is decoded whole, and one of which more was asked for
  // twice, where a few of that size fit.
  void Expect(std::size_t photo_index, const image::PixelBox& box);

  // Called with every photo that is decoded, at 1/denominator of its size, in the thread that wanted it and
  // before anybody gets it. Set before the first Get.
  using Observer = std::function<void(std::size_t photo_index, int denominator, const image::DecodedPart&)>;
  void OnDecoded(Observer observer) { observer_ = std::move(observer); }

  // At least the pixels of `box`, which counts at full size and may reach beyond the photo. Errors are those
  // of PhotoSource::DecodePart, remembered for the photo.
  Result<DecodedPhoto> Get(std::size_t photo_index, const flight::Photo& photo, int denominator,
                           const image::PixelBox& box);
  // That a photo has been asked for for the last time, as far as anybody knows: its memory serves the next.
  void Drop(std::size_t photo_index);

 private:
  class SpareMemory;
  using Key = std::pair<std::size_t, int>;
  struct Entry {
    bool is_ready = false;
    DecodedPhoto part;
    image::PixelBox box;  // what of it is known to be there, in decoded pixels
    std::optional<Error> error;
    std::list<Key>::iterator recency;
  };
  void EvictDownTo(std::int64_t bytes);
  // Takes a photo out that is not in use; false: it is, or is being decoded.
  bool Remove(std::map<Key, Entry>::iterator entry);

  const flight::PhotoSource& source_;
  // What to decode where `wanted` is asked for and `expected` will be.
  image::PixelBox DecodedBox(const image::PixelBox& wanted, const image::PixelBox& expected,
                             const image::PixelBox& whole) const;

  const std::int64_t budget_bytes_;
  std::mutex mutex_;
  std::condition_variable ready_;
  struct Expected {
    image::PixelBox box;  // in pixels of the full size
    bool was_too_little = false;
  };
  std::map<std::size_t, Expected> expected_;
  std::map<Key, Entry> entries_;
  std::list<Key> recency_;  // most recent first
  std::int64_t held_bytes_ = 0;
  const std::shared_ptr<SpareMemory> spare_;  // of photos no longer in use
  Observer observer_;
};

}  // namespace skyquilt::render
