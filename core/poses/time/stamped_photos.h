// The capture times that cameras wrote into their photos, camera by camera, as seconds. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::poses {

// "2024-06-01 10:00:05"
std::string DateInWords(flight::UtcTime time);

// The earliest stamp of all; nothing where no photo has one.
std::optional<flight::UtcTime> FirstStamp(const std::vector<flight::Photo>& photos);

// All stamps of one camera, in order.
struct StampedPhotos {
  std::vector<std::size_t> photo;  // index into the photos
  std::vector<double> stamp_s;     // since the first stamp of all
  double resolution_s = 1.0;       // what the stamps are cut to
  bool is_of_maker = true;         // false: frames of films, say, by the clock of what wrote the film
};

// The camera with the most stamps comes first, of those of a maker.
std::vector<StampedPhotos> StampsByCamera(const std::vector<flight::Photo>& photos);

}  // namespace skyquilt::poses
