// A simulated photo as a JPEG file with its EXIF and XMP. Any thread. Errors: kIo (the file could not be
// written).
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/image/decoded_image.h"
#include "core/simulate/sensors/recorded_pose.h"

namespace skyquilt::simulate {

// The same image and record give the same bytes.
std::vector<std::uint8_t> EncodePhoto(const image::DecodedImage& photo, const RecordedPose& recorded,
                                      int jpeg_quality = 92);
Result<void> WriteBytes(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes);

}  // namespace skyquilt::simulate
