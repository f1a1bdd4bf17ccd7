// FindCopies: which pictures another program made of others of the same flight: exports, edited and resized
// copies, files that exiftool kept. Two are of one exposure where the names say so and nothing the camera
// recorded contradicts, or where moment, camera and place are the same; positions never decide alone, for a
// copy's may be stale: one far away counts for nothing where several copies share it, and otherwise only a
// name ties such a picture to its original. One must be nearer to what the camera wrote (its records, no
// editor's name, its size). Pictures of a series (bursts, bracketed exposures) and the bands of one capture
// are no copies; what previews.h finds are. Any thread; n log n, at most 64 pictures looked at for each.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/flight/aside/aside.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

struct CopyOf {
  std::size_t original = 0;  // is no copy itself
  Aside why = Aside::kCopy;
};

// For each photo; nothing for those that are none.
std::vector<std::optional<CopyOf>> FindCopies(const std::vector<Photo>& photos);

// Takes the copies out of `photos`.
void LeaveOutCopies(std::vector<Photo>& photos, std::vector<LeftOutPhoto>& left_out);

}  // namespace skyquilt::flight
