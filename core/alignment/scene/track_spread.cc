#include "core/alignment/scene/track_spread.h"

#include <algorithm>
#include <span>

namespace skyquilt::alignment {

TrackSpread::TrackSpread(std::size_t photos, int observations_per_photo, int cells_across)
    : photos_(photos), cells_across_(cells_across), observations_per_photo_(observations_per_photo) {}

void TrackSpread::SeenBy(int photo, const Eigen::Vector2d& pixel_in_image, const camera::Intrinsics& lens) {
  const auto across = static_cast<int>(cells_across_);
  const auto along = [&](double pixel, int size_px) {
    return std::clamp(static_cast<int>(pixel * across / size_px), 0, across - 1);
  };
  const std::size_t at = photo;
  seen_.push_back({at, (at * cells_across_ + along(pixel_in_image.y(), lens.height_px)) * cells_across_ +
                           along(pixel_in_image.x(), lens.width_px)});
}

std::vector<std::size_t> TrackSpread::Choose() const {
  const std::size_t cells = cells_across_ * cells_across_;
  std::vector<int> in_cell(photos_ * cells, 0), in_photo(photos_, 0);
  std::vector<bool> is_chosen(begins_.size(), false);
  const int rounds = 1 + 3 * observations_per_photo_ / static_cast<int>(cells);
  for (int round = 1; round <= rounds; ++round) {
    for (std::size_t t = 0; t < begins_.size(); ++t) {
      if (is_chosen[t]) continue;
      const std::size_t end = t + 1 < begins_.size() ? begins_[t + 1] : seen_.size();
      const std::span<const PhotoCell> seen(seen_.data() + begins_[t], end - begins_[t]);
      is_chosen[t] = std::any_of(seen.begin(), seen.end(), [&](const PhotoCell& one) {
        return in_cell[one.cell] < round && in_photo[one.photo] < observations_per_photo_;
      });
      if (!is_chosen[t]) continue;
      for (const PhotoCell& one : seen) {
        ++in_cell[one.cell];
        ++in_photo[one.photo];
      }
    }
  }
  std::vector<std::size_t> chosen;
  for (std::size_t t = 0; t < is_chosen.size(); ++t) {
    if (is_chosen[t]) chosen.push_back(t);
  }
  return chosen;
}

}  // namespace skyquilt::alignment
