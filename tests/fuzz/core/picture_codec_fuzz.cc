// Pictures of tiles, as a damaged or foreign tileset may hold them.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "core/image/fringe_encoder.h"
#include "core/image/picture_codec.h"
#include "core/image/png_tile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  (void)image::DecodePngTile(bytes, 256);
  (void)image::IsWebpWithAlpha(bytes);
  const auto picture = image::DecodePicture(bytes);
  if (!picture) return 0;
  SKYQUILT_CHECK(picture->rgba.size() == 4 * static_cast<std::size_t>(picture->width_px) *
                                             static_cast<std::size_t>(picture->height_px),
                 "as many pixels as the picture's size says");
  if (picture->rgba.size() > 1 << 20) return 0;  // larger ones only take longer
  const auto png = image::EncodePicture(*picture, image::PictureFormat::kPng);
  const auto again = image::DecodePicture({reinterpret_cast<const char*>(png.data()), png.size()});
  SKYQUILT_CHECK(again && again->rgba == picture->rgba, "PNG gives the pixels back");
  const auto webp = image::EncodeFringeWebp(*picture, 50.0F);
  const auto fringe = image::DecodePicture({reinterpret_cast<const char*>(webp.data()), webp.size()});
  SKYQUILT_CHECK(fringe && fringe->rgba.size() == picture->rgba.size(), "WebP gives as many pixels back");
  for (std::size_t i = 3; i < picture->rgba.size(); i += 4)
    SKYQUILT_CHECK(fringe->rgba[i] == picture->rgba[i], "WebP gives alpha back");
  return 0;
}
