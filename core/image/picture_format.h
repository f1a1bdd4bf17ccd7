// PictureFormat: how the picture of a tile is encoded, and what the web calls it. Pure.
#pragma once

#include <optional>
#include <string_view>

namespace skyquilt::image {

enum class PictureFormat { kJpeg, kPng, kWebp };

// By the first bytes; nothing for any other format.
std::optional<PictureFormat> PictureFormatOf(std::string_view bytes);
// "image/png"
const char* ContentTypeOf(PictureFormat format);
// "png"
const char* ExtensionOf(PictureFormat format);

}  // namespace skyquilt::image
