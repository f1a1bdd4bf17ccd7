#include "core/bands/mend_sunlight.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace skyquilt::bands {
namespace {

// Whether two photos were taken so shortly after each other that their light is the same, but for a cloud's
// edge.
bool AreNeighbours(const flight::Photo& a, const flight::Photo& b) {
  constexpr std::chrono::seconds kApart{6};
  return a.captured_at && b.captured_at && std::chrono::abs(*b.captured_at - *a.captured_at) <= kApart;
}

// Of a reading between two others; nothing where it may be true.
std::optional<double> SunlightInstead(double before, double own, double after) {
  constexpr double kAgreeTimes = 1.1, kOffTimes = 2.0;
  if (std::max(before, after) > kAgreeTimes * std::min(before, after)) return std::nullopt;
  const double between = std::sqrt(before * after);
  const bool is_off = own > kOffTimes * between || between > kOffTimes * own;
  return is_off ? std::optional(between) : std::nullopt;
}

}  // namespace

void MendSunlight(Captures& captures, std::vector<flight::Remark>& warnings) {
  std::map<std::pair<std::string, std::string>, std::vector<BandPhoto*>> photos_of;  // by band and camera
  for (Capture& capture : captures.captures) {
    for (BandPhoto& photo : capture.photos) {
      if (photo.facts.radiometry.sunlight)
        photos_of[{photo.facts.name, photo.photo.camera_key}].push_back(&photo);
    }
  }
  std::size_t mended = 0;
  double most_times = 1.0;
  for (const auto& [band_and_camera, photos] : photos_of) {
    std::vector<std::optional<double>> instead(photos.size());
    for (std::size_t k = 1; k + 1 < photos.size(); ++k) {
      const BandPhoto &before = *photos[k - 1], &own = *photos[k], &after = *photos[k + 1];
      if (!AreNeighbours(before.photo, own.photo) || !AreNeighbours(own.photo, after.photo)) continue;
      instead[k] = SunlightInstead(*before.facts.radiometry.sunlight, *own.facts.radiometry.sunlight,
                                   *after.facts.radiometry.sunlight);
    }
    for (std::size_t k = 1; k + 1 < photos.size(); ++k) {
      // Between two that are off a true one stands alone too.
      if (!instead[k] || instead[k - 1] || instead[k + 1]) continue;
      Radiometry& radiometry = photos[k]->facts.radiometry;
      const double times = *radiometry.sunlight / *instead[k];
      radiometry.per_level *= times;
      radiometry.sunlight = instead[k];
      ++mended;
      most_times = std::max({most_times, times, 1.0 / times});
    }
  }
  if (mended == 0) return;
  warnings.push_back({flight::RemarkCode::kSunlightMended, {{"photos", mended}, {"times", most_times}}});
}

}  // namespace skyquilt::bands
