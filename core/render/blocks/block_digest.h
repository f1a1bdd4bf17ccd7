// DigestBlock: a digest of all that the pixels of a block depend on: the ground below it (with walls: all
// ground), the photos that may show some of it (bytes, ranges, lenses, poses, tones), its cells of the seam
// map, and the options. Two blocks of the same digest have the same tiles, so a block need not be rendered
// again when a flight is gone on with or grows. The other way round a block whose digest differs may still
// come out the same. Pure; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/base/digest.h"
#include "core/pyramid/encode_tile.h"
#include "core/render/blocks/block_geometry.h"
#include "core/render/blocks/render_block.h"

namespace skyquilt::render {

// Of a ground with steps: what is hidden depends on what stands around, so that every block depends on it.
Digest DigestSteps(const ground::GroundSurface& ground);

// photo_digests[i]: of the file of flight.photos[i]; geometry: GeometryOf(context, block); steps: DigestSteps
// where the ground has them.
Digest DigestBlock(const RenderContext& context, const pyramid::EncodeOptions& encode,
                   const std::vector<Digest>& photo_digests, const RenderBlock& block,
                   const BlockGeometry& geometry, const std::optional<Digest>& steps = {});

}  // namespace skyquilt::render
