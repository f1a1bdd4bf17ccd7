#include "core/image/picture_format.h"

namespace skyquilt::image {

std::optional<PictureFormat> PictureFormatOf(std::string_view bytes) {
  if (bytes.starts_with("\xff\xd8\xff")) return PictureFormat::kJpeg;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return PictureFormat::kPng;
  if (bytes.size() >= 12 && bytes.starts_with("RIFF") && bytes.substr(8, 4) == "WEBP")
    return PictureFormat::kWebp;
  return std::nullopt;
}

bool IsWebpWithAlpha(std::string_view bytes) {
  if (PictureFormatOf(bytes) != PictureFormat::kWebp) return false;
  // Behind the name of the first chunk and its four bytes of length.
  constexpr std::size_t kFlagsAt = 20, kLosslessFlagsAt = 24;
  constexpr int kAlpha = 0x10;
  const std::string_view chunk = bytes.substr(12, 4);
  if (chunk == "VP8X") return bytes.size() > kFlagsAt && (bytes[kFlagsAt] & kAlpha) != 0;
  if (chunk == "VP8L") return bytes.size() > kLosslessFlagsAt && (bytes[kLosslessFlagsAt] & kAlpha) != 0;
  return false;
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
