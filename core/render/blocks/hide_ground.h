// HideGround: marks in the photos' views of a block what something else stands before, where the ground has
// steps. What no photo sees at all is hidden from none, so that the map has no holes: the seams choose who
// shows it. Pure; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/render/blocks/block_geometry.h"

namespace skyquilt::render {

// views[i] belongs to photos[i], an index into the flight. `asked`: by node, whether it matters there. Gives,
// by node, where the pictures of some lie and something stands before all of them; empty: nowhere.
std::vector<bool> HideGround(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                             const std::vector<std::uint32_t>& photos, const BlockGeometry& block,
                             const std::vector<std::uint8_t>& asked, std::vector<PhotoView>& views);

}  // namespace skyquilt::render
