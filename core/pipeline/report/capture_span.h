// CaptureSpanOf: when the photos of a flight were taken, from the first to the last, as the clock on the wall
// there showed it: "2015-10-27T09:31:02-04:00". With "Z" where the zone is not known, without either where
// the clock was a local one of an unknown zone. Photos without a time are passed over; where some have UTC
// and some do not, those that have it count. Any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::pipeline {

struct CaptureSpan {
  std::string first, last;
};

std::optional<CaptureSpan> CaptureSpanOf(const std::vector<const flight::Photo*>& photos);

}  // namespace skyquilt::pipeline
