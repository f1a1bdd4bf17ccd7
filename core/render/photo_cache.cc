#include "core/render/photo_cache.h"

namespace skyquilt::render {

Result<DecodedPhoto> PhotoCache::Get(std::size_t photo_index, const flight::Photo& photo, int denominator) {
  const Key key{photo_index, denominator};
  std::unique_lock lock(mutex_);
  const auto found = entries_.find(key);
  if (found != entries_.end()) {
    // std::map keeps the entry in place; it is not evicted before it is ready.
    ready_.wait(lock, [&] {
      const auto it = entries_.find(key);
      return it == entries_.end() || it->second.is_ready;
    });
    const auto it = entries_.find(key);
    if (it != entries_.end()) {
      recency_.splice(recency_.begin(), recency_, it->second.recency);
      if (it->second.error) return *it->second.error;
      return it->second.image;
    }
  }
  recency_.push_front(key);
  entries_[key].recency = recency_.begin();
  ++decodes_;
  lock.unlock();
  Result<pipeline::DecodedImage> decoded = source_.Decode(photo, denominator);
  lock.lock();
  Entry& entry = entries_[key];
  entry.is_ready = true;
  if (!decoded) {
    entry.error = decoded.error();
    ready_.notify_all();
    return decoded.error();
  }
  entry.image = std::make_shared<const pipeline::DecodedImage>(*std::move(decoded));
  DecodedPhoto image = entry.image;
  held_bytes_ += static_cast<std::int64_t>(image->rgb.size());
  EvictDownTo(budget_bytes_);
  ready_.notify_all();
  return image;
}

void PhotoCache::EvictDownTo(std::int64_t bytes) {
  auto it = recency_.end();
  while (held_bytes_ > bytes && it != recency_.begin()) {
    --it;
    const auto entry = entries_.find(*it);
    // What is being decoded or in use stays: dropping it would free nothing.
    if (!entry->second.is_ready || !entry->second.image || entry->second.image.use_count() > 1) continue;
    held_bytes_ -= static_cast<std::int64_t>(entry->second.image->rgb.size());
    entries_.erase(entry);
    it = recency_.erase(it);
  }
}

std::int64_t PhotoCache::decodes() const {
  std::lock_guard lock(mutex_);
  return decodes_;
}

}  // namespace skyquilt::render
