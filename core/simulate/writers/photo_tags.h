// The metadata segments of a simulated photo: EXIF (TIFF structure, little endian) and XMP (the drone-dji
// namespace). Pure functions; any thread. Sources: CIPA DC-008 (Exif 2.32), Adobe XMP part 3, DJI's published
// tags.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image/decoded_image.h"
#include "core/simulate/sensors/band_rig.h"
#include "core/simulate/sensors/recorded_pose.h"

namespace skyquilt::simulate {

// The payloads of the two APP1 segments, with their signatures, without marker and length.
std::vector<std::uint8_t> ExifPayload(const RecordedPose& recorded);
std::vector<std::uint8_t> XmpPayload(const RecordedPose& recorded);

// A TIFF of one band of 16 bits with the same, and with what makes reflectance of its levels as MicaSense's
// cameras write it.
std::vector<std::uint8_t> BandTiffBytes(const RecordedPose& recorded, const RigBand& band,
                                        const BandExposure& exposure, const image::SampleImage& picture);

}  // namespace skyquilt::simulate
