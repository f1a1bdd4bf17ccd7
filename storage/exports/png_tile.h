// DecodePngTile: decodes a PNG (ISO/IEC 15948) of 8-bit RGBA without interlacing, the kind that tilesets
// hold, several times faster than a general reader. Pure. Errors: kCorrupt (any other kind of picture too).
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::storage {

// side_px x side_px pixels of red, green, blue and straight alpha.
Result<std::vector<std::uint8_t>> DecodePngTile(std::string_view bytes, int side_px);

}  // namespace skyquilt::storage
