// TranscodeTile: one encoded tile in another format; TransparentPng: an empty tile of minimal size. Pure.
// Errors: kCorrupt (bytes that do not decode), kTooLarge (a side of more than image::kMaxPictureSidePx).
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/image/picture_format.h"
#include "core/image/rgba_image.h"

namespace skyquilt::api {

// Straight alpha; JPEG is laid on white.
std::string EncodeTile(image::RgbaImage tile, image::PictureFormat to);
Result<std::string> TranscodeTile(std::string_view bytes, image::PictureFormat to);
std::string TransparentPng(int side_px);

}  // namespace skyquilt::api
