// FilePhotoSource: decodes photos from the files their records name. JPEG by libjpeg-turbo, which makes the
// smaller sizes while decoding; PNG by libpng, row by row; TIFF, and PNG of 16 bits, by OpenCV, whole.
// Samples that are more than bytes are drawn in the photo's range (sample_format.h), or in their own without
// one. Grey and CMYK become RGB. EXIF orientation is not applied. At 1/d every output pixel covers exactly d
// x d source pixels; the last row and column may hang over the edge. Any number of threads at a time; memory:
// one file's bytes and the picture or part that is asked for a call, and what a format that cannot be read by
// parts takes beside it, which is bounded.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/flight/photos/photo_source.h"
#include "core/image/decoded_image.h"

namespace skyquilt::flight {

// What decoding may take at once beside the picture that comes out, file and working memory together.
inline constexpr std::int64_t kMaxDecodeBytes = std::int64_t{1} << 30;

class FilePhotoSource final : public PhotoSource {
 public:
  // A photo whose decoding takes more than `max_bytes` is refused (kTooLarge).
  explicit FilePhotoSource(std::int64_t max_bytes = kMaxDecodeBytes) : max_bytes_(max_bytes) {}
  // Errors: kCorrupt (damaged, cut off, or not the picture it was when its header was read),
  // kUnsupportedFormat, kTooLarge, kIo, kNotFound. Asks that `denominator` is 1, 2, 4 or 8.
  Result<image::DecodedImage> Decode(const Photo& photo, int denominator) const override;
  Result<image::DecodedPart> DecodePart(const Photo& photo, int denominator, const image::PixelBox& box,
                                        PixelBytes memory) const override;
  Result<image::SampleImage> DecodeSamples(const Photo& photo) const override;
  Result<std::vector<float>> SampleValues(const Photo& photo, std::size_t most) const override;

 private:
  const std::int64_t max_bytes_;
};

// The same from bytes in memory; `width_px`, `height_px` are what the header said.
Result<image::DecodedImage> DecodePhotoBytes(const std::vector<std::uint8_t>& bytes, int width_px,
                                             int height_px, int denominator);

// A TIFF or PNG of one channel, all 16 bits of it; one of 8 bits is brought to 16. Of a thermal camera's JPEG
// the levels of its sensor.
Result<image::SampleImage> DecodeSampleBytes(const std::vector<std::uint8_t>& bytes, int width_px,
                                             int height_px, std::int64_t max_bytes = kMaxDecodeBytes);

// Of a JPEG no more than `box` and a little around it; of anything else, or with no box, everything. `range`:
// of samples that are more than bytes.
Result<image::DecodedPart> DecodePhotoPart(const std::vector<std::uint8_t>& bytes, int width_px,
                                           int height_px, int denominator,
                                           const std::optional<image::PixelBox>& box, PixelBytes memory = {},
                                           std::int64_t max_bytes = kMaxDecodeBytes,
                                           const std::optional<SampleRange>& range = {});

}  // namespace skyquilt::flight
