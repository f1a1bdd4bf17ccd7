// One photo from bytes: format, size, EXIF, XMP, maker note, brought together. Never decodes pixels and never
// holds the whole file. Any thread. Bytes may be hostile: every reader below is bounded.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

// Larger images are refused before anything decodes them.
inline constexpr int kMaxPhotoSidePx = 30000;
inline constexpr double kMaxPhotoPixels = 400e6;

// Errors: kUnsupportedFormat, kCorrupt, kTooLarge. The photo's path stays empty.
Result<Photo> ReadPhotoFrom(const std::string& name, ByteSource& source);
Result<Photo> ReadPhotoFromBytes(const std::string& name, std::span<const std::uint8_t> bytes);

}  // namespace skyquilt::flight
