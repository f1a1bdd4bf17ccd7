// PictureFormat: how the picture of a tile is encoded, and what the web calls it; TileEncoding: which of them
// the tiles of a map are. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace skyquilt::image {

enum class PictureFormat { kJpeg, kPng, kWebp };

// Of the tiles of a map.
enum class TileEncoding : std::uint8_t {
  kJpegPng,   // JPEG inside, PNG at the fringe
  kWebp,      // WebP throughout
  kJpegWebp,  // JPEG inside, WebP at the fringe
};

// By the first bytes; nothing for any other format.
std::optional<PictureFormat> PictureFormatOf(std::string_view bytes);
// A WebP whose head says that pixels may be transparent (RFC 9649, 2.5 to 2.7).
bool IsWebpWithAlpha(std::string_view bytes);
// "image/png"
const char* ContentTypeOf(PictureFormat format);
// "png"
const char* ExtensionOf(PictureFormat format);

}  // namespace skyquilt::image
