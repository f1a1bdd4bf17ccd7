// SampleFormatOfTiff, SampleKindOfPng: how a picture stores its samples, told by its header, and whether such
// samples can be drawn. The one place that decides this: what it refuses is no photo, for whoever only looks
// at headers too. Any thread. Sources: TIFF 6.0; GDAL_NODATA (42113) as GDAL's GTiff driver writes it; PNG
// 3rd edition.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/base/result.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

struct SampleFormat {
  SampleKind kind = SampleKind::kBytes;
  bool zero_is_white = false;     // of samples that are more than bytes; smaller ones are turned on decoding
  std::optional<double> no_data;  // the number that stands where nothing was measured
};

// Error: kUnsupportedFormat, which names what the samples are and what to export instead.
Result<SampleFormat> SampleFormatOfTiff(const ExifTable& tags);

// Of at least the first 26 bytes of a PNG.
SampleKind SampleKindOfPng(std::span<const std::uint8_t> start);

}  // namespace skyquilt::flight
