// LowResView: what one photo shows of the ground, cell by cell of the seam grid: colours with the exposure
// evened out, how well each cell is seen. Frames: cells of SeamGrid, enu. A value; any thread.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/geo/bounds.h"
#include "core/ground/ground_surface.h"
#include "core/render/exposure/exposure.h"
#include "core/render/seams/seam_grid.h"
#include "core/render/thumbnail.h"

namespace skyquilt::render {

// How well a photo shows a point of the ground, in metres; lower is better. Nadir distance first (things lean
// less), then how well the photo's place is known; towards its own border a photo gives way, and where its
// pixels cover far more ground than the map's.
struct ViewScore {
  float width_px = 0.0f, height_px = 0.0f;  // of the image
  float taper_px = 1.0f;
  float border_penalty_m = 0.0f;
  float constant_m = 0.0f;
  float coarse_penalty_m = 0.0f;

  static ViewScore Of(const alignment::AlignedPhoto& photo);

  // Distance to the nearest edge of the image; negative outside.
  float Margin(float x, float y) const {
    return std::min(std::min(x + 0.5f, width_px - 0.5f - x), std::min(y + 0.5f, height_px - 0.5f - y));
  }
  // For pixels that cover several times the ground of the map's: whoever sees the place better shows it.
  // `offset_m`: from the camera to the place.
  float CoarsePenalty(const Eigen::Vector3d& offset_m, double focal_px, double map_gsd_m) const;
  float Score(float nadir_distance_m, float margin_px) const {
    const float lack = std::max(0.0f, 1.0f - margin_px / taper_px);
    return nadir_distance_m + constant_m + border_penalty_m * lack * lack;
  }
};

enum class Seen : std::uint8_t { kNot, kPartly, kFully };

struct LowResView : CellWindow {
  std::vector<Seen> seen;
  std::vector<std::array<std::uint8_t, 3>> rgb;  // 0 where not seen
  std::vector<float> score_m;                    // ViewScore
  std::vector<bool> is_moving;                   // shows a moving object (MarkMoving); empty: nothing known
  float camera_east_m = 0.0f, camera_north_m = 0.0f;  // in enu
};

// `seen_in_merc` bounds what the photo sees; `map_gsd_m` is what most photos show a pixel of.
LowResView MakeLowResView(const alignment::AlignedPhoto& photo, const geo::Bounds2& seen_in_merc,
                          const geo::LocalFrame& frame, const ground::GroundSurface& ground,
                          const PhotoTone& tone, const Thumbnail& thumbnail, const SeamGrid& grid,
                          double map_gsd_m);

}  // namespace skyquilt::render
