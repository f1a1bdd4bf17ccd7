// BlockGeometry: which ground every pixel of a block shows, and where a photo sees it, on a coarse exact
// grid. Nodes lie every node_step_px pixels of the zoom's world-wide pixel grid, so that a pixel's numbers do
// not depend on the block it is rendered in; between nodes all is bilinear. Frames: merc (block), enu
// (ground), image (photo). Beside it which of its pixels the map's boundary leaves. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/geo/local_frame.h"
#include "core/geo/tile_id.h"
#include "core/ground/ground_surface.h"
#include "core/image/rgba_image.h"
#include "core/render/mosaic_plan.h"

namespace skyquilt::render {

inline constexpr int kNodeStepPx = 16;          // over smooth ground
inline constexpr int kNodeStepOverStepsPx = 2;  // where it has walls

struct BlockGeometry {
  int size_px = 0;
  int node_step_px = kNodeStepPx;
  int nodes_per_side = 0;                      // size_px / node_step_px + 1
  std::vector<Eigen::Vector3d> ground_in_enu;  // row by row from the north-west
};

BlockGeometry MakeBlockGeometry(const geo::TileId& block_tile, int size_px, const geo::LocalFrame& frame,
                                const ground::GroundSurface& ground);

// What one photo sees of a block, at the nodes.
struct PhotoView {
  // Pixel in the full-size image; NaN where the photo cannot see (behind it, beyond the lens, too oblique),
  // and where nobody asked.
  std::vector<Eigen::Vector2f> pixel_in_image;
  std::vector<float> nadir_distance_m;  // ground distance from the point straight below the camera
  // Whether something stands before the ground there that another photo sees (HideGround); empty: nowhere.
  std::vector<bool> is_hidden;
  bool sees_block = false;  // some node cell touches the image
};

PhotoView ViewBlock(const alignment::AlignedPhoto& photo, const BlockGeometry& block);
// At some nodes, by node, beside those that the view has.
void ViewNodes(const alignment::AlignedPhoto& photo, const BlockGeometry& block,
               const std::vector<std::uint8_t>& wanted, PhotoView& view);

// Which pixels of a block lie within the boundary that the map is cut to. A pixel does where its middle does.
// Memory: a byte a pixel of blocks that the boundary crosses, else nothing.
class BlockBoundary {
 public:
  BlockBoundary(const MosaicPlan& plan, const geo::TileId& block_tile);

  bool CutsNothing() const { return inside_.empty(); }
  bool Holds(int x, int y) const {
    return inside_.empty() || inside_[static_cast<std::size_t>(y) * side_ + static_cast<std::size_t>(x)] != 0;
  }
  // 1 within, 0 beyond, row by row; empty where nothing is cut.
  const std::vector<std::uint8_t>& inside() const { return inside_; }
  // Transparent black beyond.
  void Cut(image::RgbaImage& image) const;

 private:
  std::size_t side_;
  std::vector<std::uint8_t> inside_;
};

}  // namespace skyquilt::render
