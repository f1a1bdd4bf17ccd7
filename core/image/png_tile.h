// DecodePngTile: decodes a PNG (ISO/IEC 15948) of 8-bit RGBA without interlacing, the kind that tilesets
// hold, several times faster than a general reader. Pure. Errors: kCorrupt (any other kind of picture too).
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/image/rgba_image.h"

namespace skyquilt::image {

// side_px x side_px pixels; alpha as it was encoded.
Result<RgbaImage> DecodePngTile(std::string_view bytes, int side_px);

}  // namespace skyquilt::image
