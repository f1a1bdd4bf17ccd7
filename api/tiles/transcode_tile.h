// TranscodeTile: one encoded tile in another format; TileFormatOf: the format of encoded bytes, by their
// magic number; TransparentPng: an empty tile of minimal size. JPEG has no transparency: transparent pixels
// become white. Pure. Errors: kCorrupt (bytes that do not decode), kTooLarge (a tile with a side of more than
// 4096 pixels).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/pyramid/tile_sink.h"

namespace skyquilt::api {

std::optional<pyramid::TileFormat> TileFormatOf(std::string_view bytes);
const char* ContentTypeOf(pyramid::TileFormat format);
const char* ExtensionOf(pyramid::TileFormat format);

// Straight alpha, rows without padding.
struct Pixels {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
};
Result<Pixels> DecodeTile(std::string_view bytes);
// JPEG is laid on white.
std::string EncodeTile(Pixels pixels, pyramid::TileFormat to);

Result<std::string> TranscodeTile(std::string_view bytes, pyramid::TileFormat to);
std::string TransparentPng(int side_px);
inline constexpr int kMaxSidePx = 4096;
// The side of a tile from its header; absent when it does not decode.
std::optional<int> TileSidePx(std::string_view bytes);

}  // namespace skyquilt::api
