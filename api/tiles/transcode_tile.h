// TranscodeTile: one encoded tile in another format; TileFormatOf: the format of encoded bytes, by their
// magic; TransparentPng: an empty tile. JPEG has no transparency: it is laid on white. Pure; any thread.
// Errors: kCorrupt (bytes that do not decode), kTooLarge (a tile of more than 4096 pixels a side).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/pipeline/ports.h"

namespace skyquilt::api {

std::optional<pipeline::TileFormat> TileFormatOf(std::string_view bytes);
const char* ContentTypeOf(pipeline::TileFormat format);
const char* ExtensionOf(pipeline::TileFormat format);

Result<std::string> TranscodeTile(std::string_view bytes, pipeline::TileFormat to);
std::string TransparentPng(int side_px);
// The side of a tile from its header; absent when it does not decode.
std::optional<int> TileSidePx(std::string_view bytes);

}  // namespace skyquilt::api
