// EncodeFringe, EncodeFringeWebp: a picture with alpha as WebP (RFC 9649), its colours lossy, by libwebp's
// quickest method, its alpha without loss, by an encoder of our own: what is the same as above or to the left
// is matched, the rest Huffman-coded. The masks of a map's edge are long runs, for which a general encoder
// takes as long as for the colours. Deterministic. Any thread. Encoding cannot fail but for want of memory
// (std::runtime_error, std::bad_alloc).
#pragma once

#include <cstdint>
#include <vector>

#include "core/image/rgba_image.h"

namespace skyquilt::image {

// A tile at the edge of a map whose other tiles are JPEG of `jpeg_quality` (1 to 100). It is seen least and
// decides how large a small map is: its colours may miss by a little more than the JPEG's
// (tests/bench/render/fringe.cc), at 100 by no more.
std::vector<std::uint8_t> EncodeFringe(const RgbaImage& straight, int jpeg_quality);

// Straight alpha; at most 16384 pixels a side. Colours below alpha 0 are lost. Quality: 0 to 100.
std::vector<std::uint8_t> EncodeFringeWebp(const RgbaImage& straight, float quality);

}  // namespace skyquilt::image
