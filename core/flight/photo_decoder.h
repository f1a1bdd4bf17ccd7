// FilePhotoSource: decodes photos from the files their records name. JPEG by libjpeg-turbo, which makes the
// smaller sizes while decoding; PNG by libpng, row by row; TIFF by OpenCV, whole (16 bits are brought to 8).
// Grey and CMYK become RGB. EXIF orientation is not applied. At 1/d every output pixel covers exactly d x d
// source pixels; the last row and column may hang over the edge. Any number of threads at a time; memory: one
// file's bytes and the picture or part that is asked for a call, and what a format that cannot be read by parts
// takes beside it, which is bounded.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/pipeline/ports.h"

namespace skyquilt::flight {

// What decoding may take at once beside the picture that comes out, file and working memory together.
inline constexpr std::int64_t kMostDecodeBytes = std::int64_t{1} << 30;

class FilePhotoSource final : public pipeline::PhotoSource {
 public:
  // A photo whose decoding takes more than `most_bytes` is refused (kTooLarge).
  explicit FilePhotoSource(std::int64_t most_bytes = kMostDecodeBytes) : most_bytes_(most_bytes) {}
  // Errors: kCorrupt (damaged, cut off, or not the picture it was when its header was read),
  // kUnsupportedFormat, kTooLarge, kIo, kNotFound. Asks that `denominator` is 1, 2, 4 or 8.
  Result<pipeline::DecodedImage> Decode(const Photo& photo, int denominator) const override;
  Result<pipeline::DecodedPart> DecodePart(const Photo& photo, int denominator, const pipeline::PixelBox& box,
                                           PixelBytes memory) const override;

 private:
  const std::int64_t most_bytes_;
};

// The same from bytes in memory; `width_px`, `height_px` are what the header said.
Result<pipeline::DecodedImage> DecodePhotoBytes(const std::vector<std::uint8_t>& bytes, int width_px,
                                                int height_px, int denominator);

// Of a JPEG no more than `box` and a little around it; of anything else, or with no box, everything.
Result<pipeline::DecodedPart> DecodePhotoPart(const std::vector<std::uint8_t>& bytes, int width_px,
                                              int height_px, int denominator,
                                              const std::optional<pipeline::PixelBox>& box,
                                              PixelBytes memory = {},
                                              std::int64_t most_bytes = kMostDecodeBytes);

}  // namespace skyquilt::flight
