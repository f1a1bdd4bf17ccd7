// OpenElevationModel: the heights of the ground that a flight is given: the file named by --dem, or else the
// first elevation model among the flight's own files that can be read; nothing where there is none. A damaged
// one among the files costs a warning, one named by --dem is an error, as of GeotiffDem::Open.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/lists/input_file.h"
#include "core/geo/dem_source.h"

namespace skyquilt::server {

struct GivenElevations {
  std::unique_ptr<geo::DemSource> source;  // null: none
  std::vector<std::string> warnings;
};

Result<GivenElevations> OpenElevationModel(const std::string& dem_path,
                                           const std::vector<flight::InputFile>& files);

}  // namespace skyquilt::server
