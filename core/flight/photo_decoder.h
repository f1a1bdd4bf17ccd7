// FilePhotoSource: decodes photos from the files their records name. JPEG by libjpeg-turbo, which makes the
// smaller sizes while decoding; TIFF and PNG by OpenCV (16 bits are brought to 8). Grey and CMYK become RGB.
// EXIF orientation is not applied. At 1/d every output pixel covers exactly d x d source pixels; the last row
// and column may hang over the edge. Any number of threads at a time; memory: one file's bytes and one
// picture a call.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/pipeline/ports.h"

namespace skyquilt::flight {

class FilePhotoSource final : public pipeline::PhotoSource {
 public:
  // Errors: kCorrupt (damaged, cut off, or not the picture it was when its header was read),
  // kUnsupportedFormat, kTooLarge, kIo, kNotFound. Asks that `denominator` is 1, 2, 4 or 8.
  Result<pipeline::DecodedImage> Decode(const Photo& photo, int denominator) const override;
  Result<pipeline::DecodedPart> DecodePart(const Photo& photo, int denominator, const pipeline::PixelBox& box,
                                           PixelBytes memory) const override;
};

// The same from bytes in memory; `width_px`, `height_px` are what the header said.
Result<pipeline::DecodedImage> DecodePhotoBytes(const std::vector<std::uint8_t>& bytes, int width_px,
                                                int height_px, int denominator);

// Of a JPEG no more than `box` and a little around it; of anything else, or with no box, everything.
Result<pipeline::DecodedPart> DecodePhotoPart(const std::vector<std::uint8_t>& bytes, int width_px,
                                              int height_px, int denominator,
                                              const std::optional<pipeline::PixelBox>& box,
                                              PixelBytes memory = {});

}  // namespace skyquilt::flight
