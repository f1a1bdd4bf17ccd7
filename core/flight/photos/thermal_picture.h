// DecodeThermalLevels: what the sensor of a FLIR camera stored of a radiometric JPEG, at the size of the
// picture for looking, over which both show the same. Any thread. Memory: the levels, their PNG decoded.
// Errors: kCorrupt; kUnsupportedFormat for a JPEG without such levels, or of another shape than the picture.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/image/decoded_image.h"

namespace skyquilt::flight {

Result<image::SampleImage> DecodeThermalLevels(const std::vector<std::uint8_t>& jpeg, int width_px,
                                               int height_px);

}  // namespace skyquilt::flight
