#include "api/tiles/transcode_tile.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/try.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {

std::string EncodeTile(image::RgbaImage tile, image::PictureFormat to) {
  const std::vector<std::uint8_t> bytes = image::EncodePicture(std::move(tile), to);
  return {bytes.begin(), bytes.end()};
}

Result<std::string> TranscodeTile(std::string_view bytes, image::PictureFormat to) {
  SKYQUILT_TRY_ASSIGN(image::RgbaImage tile, image::DecodePicture(bytes));
  return EncodeTile(std::move(tile), to);
}

std::string TransparentPng(int side_px) {
  const std::vector<std::uint8_t> bytes =
      image::EncodePlainPng(image::RgbaImage::Transparent(side_px, side_px));
  return {bytes.begin(), bytes.end()};
}

}  // namespace skyquilt::api
