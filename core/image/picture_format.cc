#include "core/image/picture_format.h"

namespace skyquilt::image {

std::optional<PictureFormat> PictureFormatOf(std::string_view bytes) {
  if (bytes.starts_with("\xff\xd8\xff")) return PictureFormat::kJpeg;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return PictureFormat::kPng;
  if (bytes.size() >= 12 && bytes.starts_with("RIFF") && bytes.substr(8, 4) == "WEBP")
    return PictureFormat::kWebp;
  return std::nullopt;
}

const char* ContentTypeOf(PictureFormat format) {
  return format == PictureFormat::kJpeg  ? "image/jpeg"
         : format == PictureFormat::kPng ? "image/png"
                                         : "image/webp";
}

const char* ExtensionOf(PictureFormat format) {
  return format == PictureFormat::kJpeg ? "jpg" : format == PictureFormat::kPng ? "png" : "webp";
}

}  // namespace skyquilt::image
