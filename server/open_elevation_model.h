// OpenElevationModel: the heights of the ground that a flight is given: the file named by --dem, or else the
// first elevation model among the flight's own files; nothing where there is none. Errors as
// GeotiffDem::Open.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/input_file.h"
#include "core/pipeline/ports.h"

namespace skyquilt::server {

Result<std::unique_ptr<pipeline::DemSource>> OpenElevationModel(const std::string& dem_path,
                                                                const std::vector<flight::InputFile>& files);

}  // namespace skyquilt::server
