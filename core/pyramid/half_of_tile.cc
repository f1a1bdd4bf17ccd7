#include "core/pyramid/half_of_tile.h"

#include <string_view>

#include "core/base/try.h"
#include "core/image/picture_codec.h"
#include "core/pyramid/tile_image.h"

namespace skyquilt::pyramid {
namespace {

void PremultiplyAlpha(image::RgbaImage& straight) {
  for (std::size_t at = 0; at + 3 < straight.rgba.size(); at += 4) {
    std::uint8_t* pixel = straight.rgba.data() + at;
    const unsigned alpha = pixel[3];
    if (alpha == 255) continue;
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>((pixel[c] * alpha + 127) / 255);
  }
}

}  // namespace

Result<image::RgbaImage> HalfOfTile(std::span<const std::uint8_t> stored, int tile_size_px) {
  SKYQUILT_TRY_ASSIGN(
      image::RgbaImage tile,
      image::DecodePicture(std::string_view(reinterpret_cast<const char*>(stored.data()), stored.size())));
  if (tile.width_px != tile_size_px || tile.height_px != tile_size_px) {
    return Error{ErrorCode::kCorrupt,
                 "A tile of the earlier map is damaged. Delete mosaic.state beside it and start again.", ""};
  }
  PremultiplyAlpha(tile);
  return Halve(tile);
}

}  // namespace skyquilt::pyramid
