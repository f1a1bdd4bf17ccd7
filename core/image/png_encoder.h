// EncodePng: an RGBA picture as PNG (ISO/IEC 15948), many times faster than a general compressor and about as
// small for photographs: every row is predicted from its neighbours ("average"), what remains is
// Huffman-coded in one deflate block (RFC 1951), and only runs of zeros, the transparent ground, are matched.
// Lossless. Any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image/rgba_image.h"

namespace skyquilt::image {

// The square of `image` that starts at (x, y), its alpha made straight, as PNG asks.
std::vector<std::uint8_t> EncodePng(const RgbaImage& image, int x, int y, int size_px);
// The whole image, of any shape, its alpha as it is.
std::vector<std::uint8_t> EncodeWholePng(const RgbaImage& image);

}  // namespace skyquilt::image
