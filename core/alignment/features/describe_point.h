// What the surroundings of a spot look like: their main directions, and a descriptor of 4 x 4 histograms of
// gradients (D. Lowe, IJCV 2004) as RootSIFT (Arandjelovic and Zisserman, CVPR 2012) in bytes. The
// surroundings are read on a grid turned with the spot and as fine as its blur, not at every pixel. Pure; any
// thread.
#pragma once

#include <vector>

#include "core/alignment/features/scale_space.h"
#include "core/alignment/scene/keypoints.h"

namespace skyquilt::alignment {

// From the image's x axis towards its y axis (down); the strongest first, and others nearly as strong.
std::vector<float> DirectionsOf(const BlurredImage& layer, const ScalePoint& point);

Descriptor Describe(const BlurredImage& layer, const ScalePoint& point, float direction_rad);

}  // namespace skyquilt::alignment
