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
    std::vector<double> read;
    for (const BandPhoto* photo : photos) read.push_back(*photo->facts.radiometry.sunlight);
    for (std::size_t k = 1; k + 1 < photos.size(); ++k) {
      if (!AreNeighbours(photos[k - 1]->photo, photos[k]->photo) ||
          !AreNeighbours(photos[k]->photo, photos[k + 1]->photo))
        continue;
      const auto instead = SunlightInstead(read[k - 1], read[k], read[k + 1]);
      if (!instead) continue;
      Radiometry& radiometry = photos[k]->facts.radiometry;
      radiometry.per_level *= read[k] / *instead;
      radiometry.sunlight = instead;
      ++mended;
      most_times = std::max({most_times, read[k] / *instead, *instead / read[k]});
    }
  }
  if (mended == 0) return;
  warnings.push_back({flight::RemarkCode::kSunlightMended, {{"photos", mended}, {"times", most_times}}});
}

}  // namespace skyquilt::bands
