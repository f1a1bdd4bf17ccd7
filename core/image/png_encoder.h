// EncodePng: an RGBA picture as PNG (ISO/IEC 15948), many times faster than a general compressor and about as
// small for photographs: every row is predicted from its neighbours ("average"), what remains is
// Huffman-coded in one deflate block (RFC 1951), and only runs of zeros, the transparent ground, are matched.
// Lossless. Any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image/rgba_image.h"

namespace skyquilt::image {

enum class PngAlpha { kStraight, kAsItIs };

// The square of `image` that starts at (x, y), its alpha made straight, as PNG asks, or left premultiplied.
std::vector<std::uint8_t> EncodePng(const RgbaImage& image, int x, int y, int size_px,
                                    PngAlpha alpha = PngAlpha::kStraight);
// The whole image, of any shape.
std::vector<std::uint8_t> EncodeWholePng(const RgbaImage& image, PngAlpha alpha = PngAlpha::kStraight);

}  // namespace skyquilt::image
