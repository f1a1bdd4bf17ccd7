// FindPreviews: smaller pictures without any record beside photos of the same names: what cameras and
// programs lay beside their pictures for looking at them, in other folders or with other endings. One such
// picture may be another flight's; where most of a folder have their larger photo, they are its previews.
// Any thread; n log n, at most 64 pictures of one name looked at for each.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::flight {

// For each photo the one that it is a preview of, which has records; nothing for those that are none.
std::vector<std::optional<std::size_t>> FindPreviews(const std::vector<Photo>& photos);

}  // namespace skyquilt::flight
