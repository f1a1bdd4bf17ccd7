// Checks that the messages between our processes share (server/jobs/job_messages.h,
// server/preview/preview_messages.h): figures within the range of a map or preview, and texts of bounded
// length. Pure.
#pragma once

#include <cstddef>
#include <string>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::server {

inline constexpr std::size_t kMaxErrorBytes = 4 * 1024;  // of an error's message, and of its detail
inline constexpr int kMaxPhotos = 10'000'000;            // that a message may speak of

// What came over the pipe is not what our own code would have sent.
Error Untrue(std::string detail);

bool IsWithin(double value, double least, double most);
bool AreBounds(const geo::LatLonBounds& bounds);  // on Earth, also across the antimeridian
// A number beyond 0..kMaxPhotos comes as -1, which no figure is.
int CountOf(double value);
bool AreZooms(int min_zoom, int max_zoom);
// A stage's name, an id: 1 to `most` of a-z, 0-9, _ and -.
bool IsWord(const std::string& text, std::size_t most);

// Cut at the border of a character.
std::string Shortened(std::string text, std::size_t max_bytes);

}  // namespace skyquilt::server
