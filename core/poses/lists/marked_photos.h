// FindMarkedPhotos: the photos that a list of surveyed points has marks in, found as NamedPhotos finds them.
// Marks that are in no photo of the flight leave the list; the remarks say which and why. Pure.
#pragma once

#include <cstddef>
#include <vector>

#include "core/flight/logs/texts/gcp_list.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/lists/named_photos.h"

namespace skyquilt::poses {

struct MarkedPhotosFound {
  std::size_t marks = 0;            // in photos that were found
  std::size_t outside = 0;          // of those: beyond the borders of theirs
  std::vector<std::size_t> photos;  // by mark that stays
  std::vector<flight::Remark> remarks;

  // Are they pixels of other pictures than these?
  bool AreOfOtherPictures() const;
};

// Each mark's photo gets the name that the flight has for it. `photos`: those that `named` knows.
MarkedPhotosFound FindMarkedPhotos(const std::vector<flight::Photo>& photos, const NamedPhotos& named,
                                   flight::GcpList& list);

}  // namespace skyquilt::poses
