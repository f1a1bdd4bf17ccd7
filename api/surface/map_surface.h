// The heights beside a map, as files that its job was asked for (option "heights"): dsm, what the photos
// show, and dtm, the ground below. Any thread; the first to ask opens files, which may have to be fetched.
// Errors: kNotFound (the map has none), kInvalidArgument (no such name), kCorrupt, and those of fetching.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "api/common/per_revision.h"
#include "api/http/http_message.h"
#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/rasters/height_raster.h"
#include "storage/rasters/open_rasters.h"

namespace skyquilt::api {

enum class Surface : std::uint8_t { kPhotos, kGround };

struct SurfaceFiles {
  const char* name;  // in addresses and options
  const char* heights;
  const char* measured;  // which of them were
  const char* title;
};
const SurfaceFiles& FilesOf(Surface surface);

const char* NameOf(Surface surface);       // dsm, dtm
std::string HeightKeyOf(Surface surface);  // dsm_m, dtm_m
// The parameter "of"; without it, what the photos show.
Result<Surface> SurfaceIn(const Request& request);

// Of all maps below a store of blobs.
class MapSurfaces {
 public:
  explicit MapSurfaces(storage::BlobStore& blobs) : blobs_(blobs) {}
  // Those that a map has, without fetching them.
  Result<std::vector<Surface>> Of(const std::string& flight_id, std::int64_t revision);
  Result<std::shared_ptr<storage::HeightRaster>> Open(const std::string& flight_id, std::int64_t revision,
                                                      Surface surface);

 private:
  storage::BlobStore& blobs_;
  PerRevision<std::vector<Surface>> found_;
  storage::OpenRasters<storage::HeightRaster> photos_, ground_;
};

}  // namespace skyquilt::api
