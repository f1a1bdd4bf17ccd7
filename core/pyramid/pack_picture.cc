#include "core/pyramid/pack_picture.h"

#include <string_view>

#include "core/base/check.h"
#include "core/image/png_encoder.h"
#include "core/image/png_tile.h"

namespace skyquilt::pyramid {

std::vector<std::uint8_t> PackPicture(const image::RgbaImage& picture) {
  SKYQUILT_CHECK(picture.width_px == picture.height_px, "only squares are packed");
  return image::EncodePng(picture, 0, 0, picture.width_px, image::PngAlpha::kAsItIs);
}

Result<image::RgbaImage> UnpackPicture(std::span<const std::uint8_t> packed, int side_px) {
  const std::string_view bytes(reinterpret_cast<const char*>(packed.data()), packed.size());
  Result<image::RgbaImage> picture = image::DecodePngTile(bytes, side_px);
  if (!picture) {
    return Error{ErrorCode::kCorrupt,
                 "The memory of the map is damaged. Delete mosaic.state and start again.",
                 picture.error().detail};
  }
  return picture;
}

}  // namespace skyquilt::pyramid
