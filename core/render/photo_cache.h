// PhotoCache: decoded photos under a byte budget, least recently used out first. Two threads that want the same
// photo decode it once. Thread-safe; what Get returned stays valid while it is held.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "core/flight/photo.h"
#include "core/pipeline/ports.h"

namespace skyquilt::render {

using DecodedPhoto = std::shared_ptr<const pipeline::DecodedImage>;

class PhotoCache {
 public:
  PhotoCache(const pipeline::PhotoSource& source, std::int64_t budget_bytes)
      : source_(source), budget_bytes_(budget_bytes) {}

  // Errors are those of PhotoSource::Decode, remembered for the photo.
  Result<DecodedPhoto> Get(std::size_t photo_index, const flight::Photo& photo, int denominator);
  std::int64_t decodes() const;

 private:
  using Key = std::pair<std::size_t, int>;
  struct Entry {
    bool is_ready = false;
    DecodedPhoto image;
    std::optional<Error> error;
    std::list<Key>::iterator recency;
  };
  void EvictDownTo(std::int64_t bytes);

  const pipeline::PhotoSource& source_;
  const std::int64_t budget_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::map<Key, Entry> entries_;
  std::list<Key> recency_;  // most recent first
  std::int64_t held_bytes_ = 0;
  std::int64_t decodes_ = 0;
};

}  // namespace skyquilt::render
