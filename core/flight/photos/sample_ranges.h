// ChooseSampleRanges: from which to which number the photos of a camera are drawn, where their samples are
// more than bytes: one range for all its photos of a flight, so that neighbours agree, by pictures spread
// over the flight. Whole numbers that fill a few levels of sixteen bits, as a thermal camera's or those of 12
// bits in 16, signed ones and floating-point ones are spread, from what a thousandth of the samples lies
// below to what a thousandth lies above; others are of the depth of a sensor (10, 12, 14 or 16 bits). The
// same whatever the number of threads. A picture that cannot be decoded says nothing here. Memory: 4 MiB a
// camera.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/flight/photo.h"
#include "core/flight/photos/photo_source.h"

namespace skyquilt::flight {

// Samples of one picture that are looked at.
inline constexpr std::size_t kSampleValues = 1 << 16;

// Nothing where there is no number among them.
std::optional<SampleRange> RangeOf(std::vector<float> values, SampleKind kind);

void ChooseSampleRanges(std::vector<Photo>& photos, const PhotoSource& source, int threads);

}  // namespace skyquilt::flight
