#include "server/open_elevation_model.h"

#include "core/flight/elevation_model_file.h"
#include "storage/geotiff_dem.h"

namespace skyquilt::server {

Result<std::unique_ptr<pipeline::DemSource>> OpenElevationModel(const std::string& dem_path,
                                                                const std::vector<flight::InputFile>& files) {
  std::filesystem::path path = dem_path;
  if (path.empty()) {
    const std::vector<flight::InputFile> models = flight::ElevationModelsAmong(files);
    if (models.empty()) return std::unique_ptr<pipeline::DemSource>();
    path = models.front().path;
  }
  auto opened = storage::GeotiffDem::Open(path);
  if (!opened) return opened.error();
  return std::unique_ptr<pipeline::DemSource>(*std::move(opened));
}

}  // namespace skyquilt::server
