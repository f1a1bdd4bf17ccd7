// DecodePng: a PNG row by row, so that memory holds the picture that is asked for and one row, whatever its
// size. Interlaced ones come in seven passes over the whole picture and take all of it. Grey and palettes
// become RGB, 16 bits 8, alpha is dropped. What goes on behind the rows that the header has, as of a bomb,
// ends it; libpng would unpack all of it and throw it away. Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/result.h"
#include "core/image/decoded_image.h"

namespace skyquilt::image {

inline constexpr std::array<std::uint8_t, 8> kPngSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

bool IsPng(std::span<const std::uint8_t> bytes);

// For PNGs that another reader decodes: kCorrupt where the compressed rows go on behind those that the header
// has. Unpacks them for it, in bounded memory. What else may be wrong is the reader's to find.
Result<void> CheckPngEnds(std::span<const std::uint8_t> bytes);

// What DecodePng takes beside the picture that it returns.
std::int64_t PngWorkBytes(std::span<const std::uint8_t> bytes, int width_px, int height_px);

// At 1/denominator, each pixel the mean of denominator x denominator, of which the last row and column repeat
// the picture's border; of `box` (in pixels at that scale) or, without one, of everything. Errors: kCorrupt.
Result<DecodedPart> DecodePng(std::span<const std::uint8_t> bytes, int width_px, int height_px,
                              int denominator, const std::optional<PixelBox>& box, PixelBytes memory = {});

}  // namespace skyquilt::image
