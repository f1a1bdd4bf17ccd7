// Pictures that are no photos of a mapping camera, told by content, whatever their names: raw pictures and
// panoramas. Bounded: 16 directories of a TIFF, and only of one whose first is a thumbnail or has others
// below it. Any thread. Sources: TIFF 6.0 and TIFF/EP (ISO 12234-2); Adobe DNG 1.7, ExifTool's table of
// compressions; Google, Photo Sphere XMP metadata.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/base/result.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/metadata/xmp.h"

namespace skyquilt::flight {

// Of a file that begins so (16 bytes are enough): "RAF", "CR3"; empty for what has no such mark.
std::string_view RawFormatOf(std::span<const std::uint8_t> head);

// Why a TIFF, of which `first` are the tags, holds no picture as others hold it; nothing for a photo.
std::optional<Error> WhyRaw(const ExifTable& first, ByteSource& source);

std::optional<Error> WhyPanorama(int width_px, int height_px, const XmpTags& xmp);

}  // namespace skyquilt::flight
