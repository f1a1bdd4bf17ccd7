#include "api/tiles/map_bands.h"

#include <utility>

#include "core/base/try.h"
#include "storage/files/data_dir.h"

namespace skyquilt::api {

Result<std::shared_ptr<storage::BandRaster>> MapBands::Of(const storage::Tileset& tileset) {
  using Raster = std::shared_ptr<storage::BandRaster>;
  const std::int64_t revision = tileset.revision.revision;
  return opened_.Get(tileset.flight_id, revision, [&]() -> Result<Raster> {
    const Result<storage::LocalBlob> file =
        blobs_.Local(storage::RevisionPrefix(tileset.flight_id, revision) + "bands.tif");
    if (!file && file.error().code == ErrorCode::kNotFound) return Raster();
    if (!file) return file.error();
    SKYQUILT_TRY_ASSIGN(Raster raster, storage::BandRaster::Open(file->path));
    return storage::KeepingFile(std::move(raster), *file);
  });
}

}  // namespace skyquilt::api
