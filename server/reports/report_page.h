// ReportPage: a finished map's report.json and picture as one HTML page: self-contained, printable, without
// scripts. What the report does not have is left out; names of others are escaped. Pure. Error: kCorrupt (no
// report).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/reports/map_picture.h"

namespace skyquilt::server {

// `picture`: absent where there is none to show. `made`: when, for people. `name`: that the map goes by now;
// empty: as the report says.
Result<std::string> ReportPage(std::string_view report_json, const std::optional<MapPicture>& picture,
                               const std::string& made, const std::string& name = "");

}  // namespace skyquilt::server
