// BlockGeometry: which ground every pixel of a block shows, and where a photo sees it, on a coarse exact
// grid. Nodes lie every node_step_px pixels of the zoom's world-wide pixel grid, so that a pixel's numbers do
// not depend on the block it is rendered in; between nodes all is bilinear. Frames: merc (block), enu
// (ground), image (photo). Values; any thread.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/geo/local_frame.h"
#include "core/geo/tile_id.h"
#include "core/ground/ground_surface.h"

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
  // Whether something stands before the ground there that another photo sees (hide_ground.h); empty: nowhere.
  std::vector<bool> is_hidden;
  bool sees_block = false;  // some node cell touches the image
};

PhotoView ViewBlock(const alignment::AlignedPhoto& photo, const BlockGeometry& block);
// At some nodes, by node, beside those that the view has.
void ViewNodes(const alignment::AlignedPhoto& photo, const BlockGeometry& block,
               const std::vector<std::uint8_t>& wanted, PhotoView& view);

}  // namespace skyquilt::render
