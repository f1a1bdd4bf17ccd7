// How a picture stores its samples, told by its header, whether such samples can be drawn, and from which
// number to which. The one place that decides this: what it refuses is no photo, for whoever only looks at
// headers too. Any thread. Sources: TIFF 6.0; GDAL_NODATA (42113) as GDAL's GTiff driver writes it; PNG 3rd
// edition.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/photo.h"
#include "core/flight/photos/photo_source.h"

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

// Samples of one picture that are looked at.
inline constexpr std::size_t kSampleValues = 1 << 16;

// From which to which number samples that are more than bytes are drawn. Whole numbers that fill a few levels
// of sixteen bits, as a thermal camera's or those of 12 bits in 16, signed ones and floating-point ones are
// spread, from what a thousandth of the samples lies below to what a thousandth lies above; others are of the
// depth of a sensor (10, 12, 14 or 16 bits). Nothing where there is no number among them.
std::optional<SampleRange> RangeOf(std::vector<float> values, SampleKind kind);

// One range for all photos of a camera, so that neighbours agree, by pictures spread over the flight. The
// same whatever the number of threads. A picture that cannot be decoded says nothing. Memory: 4 MiB a camera.
void ChooseSampleRanges(std::vector<Photo>& photos, const PhotoSource& source, int threads);

}  // namespace skyquilt::flight
