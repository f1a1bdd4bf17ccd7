#include "core/render/blocks/photo_cache.h"

#include <algorithm>
#include <iterator>

#include "core/base/trace.h"

namespace skyquilt::render {
namespace {

using image::PixelBox;

// Memory of so many photos is kept for the next ones: what threads may want at once.
constexpr std::size_t kMaxSpare = 4;
constexpr std::int64_t kPartsInBudget = 4;  // of photos decoded at once: two threads' and the next ones'

std::int64_t BytesOf(const DecodedPhoto& part) { return static_cast<std::int64_t>(part->image.rgb.size()); }

std::int64_t BytesOf(const PixelBox& box) {
  return std::int64_t{3} * (box.right - box.left) * (box.bottom - box.top);
}

int FloorDiv(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

PixelBox AtScale(const PixelBox& box, int denominator) {
  return {FloorDiv(box.left, denominator), FloorDiv(box.top, denominator), -FloorDiv(-box.right, denominator),
          -FloorDiv(-box.bottom, denominator)};
}

}  // namespace

class PhotoCache::SpareMemory {
 public:
  explicit SpareMemory(std::int64_t max_bytes) : max_bytes_(max_bytes) {}
  void Give(PixelBytes memory) {
    std::lock_guard lock(mutex_);
    std::int64_t held_bytes = static_cast<std::int64_t>(memory.capacity());
    for (const PixelBytes& kept : kept_) held_bytes += static_cast<std::int64_t>(kept.capacity());
    if (kept_.size() < kMaxSpare && held_bytes <= max_bytes_) kept_.push_back(std::move(memory));
  }
  // The largest that there is, for a picture of any size.
  PixelBytes Take() {
    std::lock_guard lock(mutex_);
    if (kept_.empty()) return {};
    const auto largest = std::max_element(
        kept_.begin(), kept_.end(), [](const auto& a, const auto& b) { return a.capacity() < b.capacity(); });
    PixelBytes memory = std::move(*largest);
    kept_.erase(largest);
    return memory;
  }

 private:
  const std::int64_t max_bytes_;
  std::mutex mutex_;
  std::vector<PixelBytes> kept_;
};

PhotoCache::PhotoCache(const flight::PhotoSource& source, std::int64_t budget_bytes)
    : source_(source),
      budget_bytes_(budget_bytes),
      spare_(std::make_shared<SpareMemory>(budget_bytes / kPartsInBudget)) {}

PixelBox PhotoCache::DecodedBox(const PixelBox& wanted, const PixelBox& expected,
                                const PixelBox& whole) const {
  const std::int64_t max_bytes = budget_bytes_ / kPartsInBudget;
  if (wanted.IsEmpty() || BytesOf(expected) <= max_bytes) return expected;
  PixelBox around = wanted;
  for (int by = 64;; by *= 2) {
    const PixelBox larger = wanted.Grown(by).Within(whole);
    if (BytesOf(larger) > max_bytes || larger.Contains(whole)) return around;
    around = larger;
  }
}

void PhotoCache::Expect(std::size_t photo_index, const PixelBox& box) {
  std::lock_guard lock(mutex_);
  PixelBox& expected = expected_[photo_index].box;
  expected = expected.With(box);
}

Result<DecodedPhoto> PhotoCache::Get(std::size_t photo_index, const flight::Photo& photo, int denominator,
                                     const PixelBox& box) {
  const PixelBox all{0, 0, photo.intrinsics.width_px, photo.intrinsics.height_px};
  const PixelBox whole = AtScale(all, denominator);
  const PixelBox wanted = AtScale(box, denominator).Within(whole);
  const Key key{photo_index, denominator};
  std::unique_lock lock(mutex_);
  // std::map keeps the entry in place; it is not evicted before it is ready.
  for (auto found = entries_.find(key); found != entries_.end(); found = entries_.find(key)) {
    Entry& there = found->second;
    if (!there.is_ready) {
      ready_.wait(lock);
      continue;
    }
    recency_.splice(recency_.begin(), recency_, there.recency);
    if (there.error) return *there.error;
    if (wanted.IsEmpty() || there.box.Contains(wanted)) return there.part;
    break;
  }
  const auto [at, is_new] = entries_.try_emplace(key);
  Entry& entry = at->second;
  if (is_new) {
    recency_.push_front(key);
    entry.recency = recency_.begin();
  } else {
    held_bytes_ -= BytesOf(entry.part);
    entry.part.reset();
    entry.is_ready = false;
  }
  const auto expected = expected_.find(photo_index);
  PixelBox more = whole;
  if (expected != expected_.end()) {
    auto& [expected_box, was_too_little] = expected->second;
    const auto fits = [&](const PixelBox& part) { return BytesOf(part) <= budget_bytes_ / kPartsInBudget; };
    // Where too little was expected twice, that would go on.
    const bool takes_all = !is_new && was_too_little && fits(whole);
    was_too_little = was_too_little || !is_new;
    if (!takes_all) more = entry.box.With(wanted).With(AtScale(expected_box, denominator).Within(whole));
    if (fits(more)) expected_box = takes_all ? all : expected_box.With(box);
  }
  entry.box = DecodedBox(wanted, more, whole);
  lock.unlock();
  const auto decode = [&] {
    const TraceSpan span("decode for the map", photo.name);
    return source_.DecodePart(photo, denominator, entry.box, spare_->Take());
  };
  Result<image::DecodedPart> decoded = [&] {
    try {
      Result<image::DecodedPart> part = decode();
      if (part && observer_) observer_(photo_index, denominator, *part);
      return part;
    } catch (...) {  // want of memory: whoever waits for it must not wait for ever
      lock.lock();
      recency_.erase(entry.recency);
      entries_.erase(key);
      ready_.notify_all();
      throw;
    }
  }();
  lock.lock();
  entry.is_ready = true;
  ready_.notify_all();
  if (!decoded) {
    entry.error = decoded.error();
    return decoded.error();
  }
  entry.part.reset(new image::DecodedPart(*std::move(decoded)), [spare = spare_](image::DecodedPart* gone) {
    spare->Give(std::move(gone->image.rgb));
    delete gone;
  });
  DecodedPhoto part = entry.part;
  held_bytes_ += BytesOf(part);
  EvictDownTo(budget_bytes_);
  return part;
}

bool PhotoCache::Remove(std::map<Key, Entry>::iterator entry) {
  Entry& gone = entry->second;
  // What is being decoded or in use stays: dropping it would free nothing.
  if (!gone.is_ready || !gone.part || gone.part.use_count() > 1) return false;
  held_bytes_ -= BytesOf(gone.part);
  recency_.erase(gone.recency);
  entries_.erase(entry);
  return true;
}

void PhotoCache::EvictDownTo(std::int64_t bytes) {
  auto it = recency_.end();
  while (held_bytes_ > bytes && it != recency_.begin()) {
    const auto oldest = std::prev(it);
    if (!Remove(entries_.find(*oldest))) it = oldest;
  }
}

void PhotoCache::Drop(std::size_t photo_index) {
  std::lock_guard lock(mutex_);
  for (auto entry = entries_.lower_bound({photo_index, 0});
       entry != entries_.end() && entry->first.first == photo_index;) {
    Remove(entry++);
  }
}

}  // namespace skyquilt::render
