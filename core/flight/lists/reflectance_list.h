// reflectance.csv: what is known to send back how much light, and where it is seen. One row for each panel in
// a photo or target on the ground; a header names the columns, in any order and case:
//   photo                          the picture of the panel; with left, top, right, bottom (pixels) where in
//                                  it, without them the panel's code is looked for
//   lat, lon (deg), radius_m       a round target on the ground
//   reflectance, or a column for   shares of light, 0 to 1 (or per cent with a sign: 52%)
//   each band (green, nir, ...)
// Pure; any thread. Errors: kUnsupportedFormat (columns are missing), kCorrupt (no row can be used). Rows
// that cannot are said in the warnings.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {

inline constexpr std::string_view kReflectanceListName = "reflectance.csv";

// Shares of light, 0 to 1.
struct KnownReflectance {
  std::optional<double> all;            // of every band that has none of its own
  std::map<std::string, double> bands;  // by the name of the column, lower case, without blanks
};

struct PanelInPhoto {
  std::string photo;
  std::optional<std::array<double, 4>> box_px;  // left, top, right, bottom
  KnownReflectance reflectance;                 // empty: what the panel's code says
};

struct GroundTarget {
  geo::LatLon center;
  double radius_m = 0.0;
  KnownReflectance reflectance;
};

struct ReflectanceList {
  std::string file_name;
  std::vector<PanelInPhoto> panels;
  std::vector<GroundTarget> targets;
  std::vector<Remark> warnings;
};

// The row of a photo, whatever the case of its name, also with folders before it that the photo's own name
// lacks; null where none names it.
const PanelInPhoto* FindPanelRow(const std::vector<ReflectanceList>& lists, std::string_view photo);

bool IsReflectanceList(std::string_view name);
Result<ReflectanceList> ParseReflectanceList(std::string_view name, std::string_view text);
// Also: kIo, kTooLarge (more than a megabyte).
Result<ReflectanceList> ReadReflectanceList(const InputFile& file);

}  // namespace skyquilt::flight
