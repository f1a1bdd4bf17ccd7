// PhotoSource: the port through which the stages get photos' pixels. Implemented by PhotoDecoder for files,
// and by sources that hold pictures in memory.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/base/try.h"
#include "core/flight/photo.h"
#include "core/image/decoded_image.h"

namespace skyquilt::flight {

class PhotoSource {
 public:
  virtual ~PhotoSource() = default;
  // Decodes at 1/denominator of the size (1, 2, 4 or 8; sides rounded up). Any number of threads at a time.
  // Errors: kCorrupt (damaged or cut off), kUnsupportedFormat, kIo.
  virtual Result<image::DecodedImage> Decode(const Photo& photo, int denominator) const = 0;
  // At least those pixels of what Decode gives; damage elsewhere may go unnoticed. `memory` is given up
  // by the caller; an implementation may reuse it for the pixels, which saves an allocation.
  virtual Result<image::DecodedPart> DecodePart(const Photo& photo, int denominator,
                                                const image::PixelBox& /*box*/, PixelBytes /*memory*/) const {
    SKYQUILT_TRY_ASSIGN(image::DecodedImage whole, Decode(photo, denominator));
    return image::DecodedPart{std::move(whole)};
  }
  // The picture of a photo of one channel as its sensor stored it. Errors: as Decode; kUnsupportedFormat
  // where the picture has colours, or the source holds none of one channel.
  virtual Result<image::SampleImage> DecodeSamples(const Photo& photo) const {
    return Error{ErrorCode::kUnsupportedFormat, photo.name + " is no picture of one band.", ""};
  }
  // Of a photo whose samples are more than bytes: about `most` of them, spread evenly over the picture, of
  // all channels, without what stands where nothing was measured. Errors: as Decode; kUnsupportedFormat where
  // samples are bytes, or the source holds no others.
  virtual Result<std::vector<float>> SampleValues(const Photo& photo, std::size_t /*most*/) const {
    return Error{ErrorCode::kUnsupportedFormat, photo.name + " has no samples beyond 8 bits.", ""};
  }
};

}  // namespace skyquilt::flight
