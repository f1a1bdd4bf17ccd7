#include "api/surface/known_surfaces.h"

#include "api/surface/map_surface.h"
#include "core/base/try.h"

namespace skyquilt::api {

Result<std::vector<Surface>> KnownSurfaces::Of(storage::BlobStore& blobs, const std::string& flight_id,
                                               std::int64_t revision) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = known_.find(flight_id);
    if (found != known_.end() && found->second.revision == revision) return found->second.surfaces;
  }
  std::vector<Surface> surfaces;
  const std::string map = storage::RevisionPrefix(flight_id, revision);
  for (const Surface surface : {Surface::kPhotos, Surface::kGround}) {
    // The file of heights alone may be somebody's elevation model.
    const Result<storage::BlobInfo> found = blobs.Find(map + FilesOf(surface).measured);
    if (!found && found.error().code != ErrorCode::kNotFound) return found.error();
    if (found) surfaces.push_back(surface);
  }
  const std::lock_guard lock(mutex_);
  if (known_.size() >= kMaxKnown) known_.erase(known_.begin());
  known_[flight_id] = {revision, surfaces};
  return surfaces;
}

}  // namespace skyquilt::api
