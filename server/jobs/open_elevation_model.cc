#include "server/jobs/open_elevation_model.h"

#include "core/flight/lists/elevation_model_file.h"
#include "storage/rasters/geotiff_dem.h"

namespace skyquilt::server {
namespace {

Result<std::unique_ptr<storage::GeotiffDem>> Open(const std::filesystem::path& path) {
  const Result<void> short_enough = flight::CheckTiffDirectories(path);
  if (!short_enough) return short_enough.error();
  return storage::GeotiffDem::Open(path);
}

}  // namespace

Result<GivenElevations> OpenElevationModel(const std::string& dem_path,
                                           const std::vector<flight::InputFile>& files) {
  GivenElevations given;
  if (!dem_path.empty()) {
    auto opened = Open(dem_path);
    if (!opened) return opened.error();
    given.source = *std::move(opened);
    return given;
  }
  for (const flight::InputFile& model : flight::ElevationModelsAmong(files)) {
    auto opened = Open(model.path);
    if (opened) {
      given.source = *std::move(opened);
      return given;
    }
    given.warnings.push_back(model.name + " is not used for the ground's heights: " + opened.error().message);
  }
  return given;
}

}  // namespace skyquilt::server
