#include "core/poses/time/stamped_photos.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/flight/bytes/written_time.h"

namespace skyquilt::poses {
namespace {

using flight::Photo;

// Whole seconds, tenths, hundredths or milliseconds: the coarsest that all stamps keep to.
double ResolutionOf(const std::vector<Photo>& photos, const StampedPhotos& camera) {
  for (const std::int64_t unit_us : {1'000'000, 100'000, 10'000}) {
    const bool all = std::all_of(camera.photo.begin(), camera.photo.end(), [&](std::size_t i) {
      return photos[i].captured_at->time_since_epoch().count() % unit_us == 0;
    });
    if (all) return static_cast<double>(unit_us) * 1e-6;
  }
  return 1e-3;
}

}  // namespace

std::string DateInWords(flight::UtcTime time) {
  std::string words = flight::WrittenSecond(time);
  std::replace(words.begin(), words.end(), 'T', ' ');
  return words;
}

std::optional<flight::UtcTime> FirstStamp(const std::vector<Photo>& photos) {
  std::optional<flight::UtcTime> first;
  for (const Photo& photo : photos) {
    if (photo.captured_at && (!first || *photo.captured_at < *first)) first = photo.captured_at;
  }
  return first;
}

std::vector<StampedPhotos> StampsByCamera(const std::vector<Photo>& photos) {
  const std::optional<flight::UtcTime> first = FirstStamp(photos);
  std::map<std::string, StampedPhotos> by_key;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].captured_at) continue;
    StampedPhotos& camera = by_key[photos[i].camera_key];
    camera.photo.push_back(i);
    camera.stamp_s.push_back(flight::SecondsBetween(*first, *photos[i].captured_at));
  }
  std::vector<StampedPhotos> cameras;
  for (auto& [key, camera] : by_key) {
    if (!std::is_sorted(camera.stamp_s.begin(), camera.stamp_s.end())) {
      std::vector<std::size_t> order(camera.photo.size());
      for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
      std::stable_sort(order.begin(), order.end(), [&stamp_s = camera.stamp_s](std::size_t a, std::size_t b) {
        return stamp_s[a] < stamp_s[b];
      });
      StampedPhotos sorted;
      for (const std::size_t i : order) {
        sorted.photo.push_back(camera.photo[i]);
        sorted.stamp_s.push_back(camera.stamp_s[i]);
      }
      camera = std::move(sorted);
    }
    camera.resolution_s = ResolutionOf(photos, camera);
    const Photo& one = photos[camera.photo.front()];
    camera.is_of_maker = !one.make.empty() || !one.model.empty();
    cameras.push_back(std::move(camera));
  }
  std::stable_sort(cameras.begin(), cameras.end(), [](const StampedPhotos& a, const StampedPhotos& b) {
    return std::pair(a.is_of_maker, a.photo.size()) > std::pair(b.is_of_maker, b.photo.size());
  });
  return cameras;
}

}  // namespace skyquilt::poses
