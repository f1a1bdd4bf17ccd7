// DecodeJpeg: the pixels of a JPEG, or of a rectangle of it, by libjpeg-turbo, which also makes the smaller
// sizes while it decodes. What lies below the rectangle is not read, what lies beside and above it is not
// turned into pixels; the pixels of the rectangle are those of the whole picture. Grey and CMYK become RGB.
// Any thread. Errors: kCorrupt (damaged, cut off above the rectangle's lower edge, of another size than
// said).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/base/result.h"
#include "core/image/decoded_image.h"

namespace skyquilt::image {

// `box`: of the decoded picture, nothing for all of it. What comes back holds at least that, in `memory` if
// that is large enough.
Result<DecodedPart> DecodeJpeg(std::span<const std::uint8_t> bytes, int width_px, int height_px,
                               int denominator, const std::optional<PixelBox>& box, PixelBytes memory);

// What DecodeJpeg takes beside the picture that it returns: of a progressive one, or any whose colours come
// one after the other, the coefficients of the whole picture.
std::int64_t JpegWorkBytes(std::span<const std::uint8_t> bytes, int width_px, int height_px);

}  // namespace skyquilt::image
