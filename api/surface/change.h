// How the heights of a map differ from those that another flight of the same ground left: the parameter
// "since". Both maps were placed by what their own flights recorded; what lies off between them is taken out
// (core/surface/terrain/height_shift), computed once for two maps. As tiles in colours: nothing where either
// flight measured nothing or the difference is less than what two flights can tell. GET
// /tiles/{flight}/change.json and /tiles/{flight}/change/{z}/{x}/{y}. Any thread. Errors: kInvalidArgument
// (no such parameter), kNotFound (no such flight, none that the token opens, or no heights), kUnprocessable
// (too little that both measured), kCorrupt, and those of fetching.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "api/http/router.h"
#include "api/service.h"
#include "core/base/result.h"
#include "core/surface/terrain/height_shift.h"
#include "storage/rasters/height_raster.h"

namespace skyquilt::api {

struct HeightChange {
  std::shared_ptr<storage::HeightRaster> now, then;
  surface::HeightShift shift;  // of now against then
  Eigen::Vector2d shift_merc_m = Eigen::Vector2d::Zero();
};

// The other flight of a request: "since", and whether what the maps lie off each other is taken out ("align",
// auto or none: both are taken as they were placed).
struct Earlier {
  std::string flight_id;
  bool is_aligned = true;
};
// Absent: none is asked for.
Result<std::optional<Earlier>> EarlierIn(const Request& request);
Result<HeightChange> ChangeSince(Service& service, const storage::Tileset& shown,
                                 const storage::Tileset& before, Surface surface, bool is_aligned);
// east_m, north_m, up_m, sigma_m, alike_share; null: not known.
nlohmann::ordered_json ShiftJson(const surface::HeightShift& shift);

}  // namespace skyquilt::api
