// OpenElevationModel: the ground heights for a flight: the file given by --dem, or else the first readable
// elevation model among the flight's own files; none where there is neither. A damaged one among the files
// causes a warning, one given by --dem an error, as of GeotiffDem::Open.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/dem_source.h"

namespace skyquilt::server {

struct GivenElevations {
  std::unique_ptr<geo::DemSource> source;  // null: none
  std::vector<flight::Remark> warnings;
};

Result<GivenElevations> OpenElevationModel(const std::string& dem_path,
                                           const std::vector<flight::InputFile>& files);

}  // namespace skyquilt::server
