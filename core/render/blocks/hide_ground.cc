#include "core/render/blocks/hide_ground.h"

#include <cstddef>

#include "core/ground/ground_surface.h"

namespace skyquilt::render {

std::vector<bool> HideGround(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                             const std::vector<std::uint32_t>& photos, const BlockGeometry& block,
                             const std::vector<std::uint8_t>& asked, std::vector<PhotoView>& views) {
  std::vector<bool> from_all;
  if (!ground.HasSteps()) return from_all;
  std::vector<Eigen::Vector3d> centers;
  centers.reserve(photos.size());
  for (const std::uint32_t photo : photos)
    centers.push_back(flight.photos[photo].cam_from_enu.TargetOriginInSource());
  std::vector<std::size_t> hiding;
  for (std::size_t node = 0; node < block.ground_in_enu.size(); ++node) {
    if (asked[node] == 0) continue;
    hiding.clear();
    bool is_seen = false;
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (!views[i].sees_block) continue;
      const camera::Intrinsics& lens = flight.photos[photos[i]].intrinsics;
      const Eigen::Vector2f& pixel = views[i].pixel_in_image[node];
      const bool is_inside = pixel.x() >= 0.0f && pixel.y() >= 0.0f &&
                             pixel.x() < static_cast<float>(lens.width_px) &&
                             pixel.y() < static_cast<float>(lens.height_px);
      if (!is_inside) continue;
      if (ground::IsOccluded(ground, block.ground_in_enu[node], centers[i])) {
        hiding.push_back(i);
      } else {
        is_seen = true;
      }
    }
    if (!is_seen) {
      if (hiding.empty()) continue;
      if (from_all.empty()) from_all.resize(block.ground_in_enu.size());
      from_all[node] = true;
      continue;
    }
    for (const std::size_t i : hiding) {
      if (views[i].is_hidden.empty()) views[i].is_hidden.resize(block.ground_in_enu.size());
      views[i].is_hidden[node] = true;
    }
  }
  return from_all;
}

}  // namespace skyquilt::render
