#include "server/inputs/open_elevation_model.h"

#include "core/base/try.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/lists/file_kinds.h"
#include "core/flight/remarks/because.h"
#include "storage/rasters/geotiff_dem.h"

namespace skyquilt::server {
namespace {

Result<std::unique_ptr<storage::GeotiffDem>> Open(const std::filesystem::path& path) {
  SKYQUILT_TRY(flight::CheckTiffDirectories(path));
  return storage::GeotiffDem::Open(path);
}

void Take(std::unique_ptr<storage::GeotiffDem> model, const std::string& file, GivenElevations& given) {
  if (!model->unknown_unit().empty()) {
    given.warnings.push_back({flight::RemarkCode::kElevationModelUnit,
                              {{"file", file}, {"unit", flight::Quoted(model->unknown_unit())}}});
  }
  given.source = std::move(model);
}

}  // namespace

Result<GivenElevations> OpenElevationModel(const std::string& dem_path,
                                           const std::vector<flight::InputFile>& files) {
  GivenElevations given;
  if (!dem_path.empty()) {
    SKYQUILT_TRY_ASSIGN(auto opened, Open(dem_path));
    Take(std::move(opened), dem_path, given);
    for (const flight::InputFile& model : flight::ElevationModelsAmong(files)) {
      given.warnings.push_back(
          {flight::RemarkCode::kElevationModelGiven, {{"file", model.name}, {"given", dem_path}}});
    }
    return given;
  }
  for (const flight::InputFile& model : flight::ElevationModelsAmong(files)) {
    auto opened = Open(model.path);
    if (opened) {
      Take(*std::move(opened), model.name, given);
      return given;
    }
    given.warnings.push_back({flight::RemarkCode::kElevationModelNotRead,
                              {{"file", model.name}, {"why", flight::WhyOf(opened.error())}}});
  }
  return given;
}

}  // namespace skyquilt::server
