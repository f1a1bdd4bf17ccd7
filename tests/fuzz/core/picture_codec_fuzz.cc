// Pictures of tiles, as a damaged or foreign tileset may hold them.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "core/image/picture_codec.h"
#include "core/image/png_tile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  (void)image::DecodePngTile(bytes, 256);
  const auto picture = image::DecodePicture(bytes);
  if (!picture) return 0;
  SKYQUILT_CHECK(picture->rgba.size() == 4 * static_cast<std::size_t>(picture->width_px) *
                                             static_cast<std::size_t>(picture->height_px),
                 "as many pixels as the picture's size says");
  if (picture->rgba.size() > 1 << 20) return 0;  // larger ones only take longer
  const auto png = image::EncodePicture(*picture, image::PictureFormat::kPng);
  const auto again = image::DecodePicture({reinterpret_cast<const char*>(png.data()), png.size()});
  SKYQUILT_CHECK(again && again->rgba == picture->rgba, "PNG gives the pixels back");
  return 0;
}
