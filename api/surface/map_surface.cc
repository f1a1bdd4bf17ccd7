#include "api/surface/map_surface.h"

#include <fmt/format.h>

#include <utility>

#include "core/base/try.h"
#include "storage/files/data_dir.h"

namespace skyquilt::api {

const SurfaceFiles& FilesOf(Surface surface) {
  static constexpr SurfaceFiles kFiles[] = {
      {"dsm", "dsm.tif", "dsm_photos.tif", "Heights of what the photos show"},
      {"dtm", "dtm.tif", "dtm_ground.tif", "Heights of the ground"}};
  return kFiles[static_cast<std::size_t>(surface)];
}

const char* NameOf(Surface surface) { return FilesOf(surface).name; }
std::string HeightKeyOf(Surface surface) { return fmt::format("{}_m", NameOf(surface)); }

Result<Surface> SurfaceIn(const Request& request) {
  const std::string_view name = request.Query("of").value_or(NameOf(Surface::kPhotos));
  for (const Surface surface : {Surface::kPhotos, Surface::kGround}) {
    if (name == NameOf(surface)) return surface;
  }
  return Error{ErrorCode::kInvalidArgument, "The parameter \"of\" is dsm (what the photos show) or dtm."};
}

Result<std::vector<Surface>> MapSurfaces::Of(const std::string& flight_id, std::int64_t revision) {
  return found_.Of(flight_id, revision, [&]() -> Result<std::vector<Surface>> {
    std::vector<Surface> surfaces;
    const std::string map = storage::RevisionPrefix(flight_id, revision);
    for (const Surface surface : {Surface::kPhotos, Surface::kGround}) {
      // The file of heights alone may be somebody's elevation model.
      const Result<storage::BlobInfo> found = blobs_.Find(map + FilesOf(surface).measured);
      if (!found && found.error().code != ErrorCode::kNotFound) return found.error();
      if (found) surfaces.push_back(surface);
    }
    return surfaces;
  });
}

Result<std::shared_ptr<storage::HeightRaster>> MapSurfaces::Open(const std::string& flight_id,
                                                                 std::int64_t revision, Surface surface) {
  using Raster = std::shared_ptr<storage::HeightRaster>;
  const SurfaceFiles& files = FilesOf(surface);
  auto& opened = surface == Surface::kPhotos ? photos_ : ground_;
  SKYQUILT_TRY_ASSIGN(const Raster raster, opened.Get(flight_id, revision, [&]() -> Result<Raster> {
    const std::string map = storage::RevisionPrefix(flight_id, revision);
    const Result<storage::LocalBlob> measured = blobs_.Local(map + files.measured);
    if (!measured && measured.error().code == ErrorCode::kNotFound) return Raster();
    if (!measured) return measured.error();
    SKYQUILT_TRY_ASSIGN(const storage::LocalBlob heights, blobs_.Local(map + files.heights));
    SKYQUILT_TRY_ASSIGN(Raster found, storage::HeightRaster::Open(heights.path, measured->path));
    return storage::KeepingFile(storage::KeepingFile(std::move(found), heights), *measured);
  }));
  if (raster) return raster;
  return Error{ErrorCode::kNotFound,
               fmt::format("This map was made without heights of this kind. Start a job with \"heights\": "
                           "\"{}\".",
                           files.name)};
}

}  // namespace skyquilt::api
