// PackPicture, UnpackPicture: a square picture kept for later without loss, its premultiplied alpha as it is
// (which is why it is not a picture for others, though it is a PNG). Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/image/rgba_image.h"

namespace skyquilt::pyramid {

std::vector<std::uint8_t> PackPicture(const image::RgbaImage& picture);
// Errors: kCorrupt (not what PackPicture made of a picture of this size).
Result<image::RgbaImage> UnpackPicture(std::span<const std::uint8_t> packed, int side_px);

}  // namespace skyquilt::pyramid
