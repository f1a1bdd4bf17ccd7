// Ground control points as ODM lists them (gcp_list.txt): a reference system in the first line, then
// "x y z pixel_x pixel_y image [name]" per sighting, cut at tabs, semicolons, commas or blanks; a line of
// column names may stand below the system, and say that the northing comes first. Rows that are not cut at
// blanks may have blanks within their names; one whose image is "-" is a point without a mark. Any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {

// A point whose name ends in "check", in any case, is compared with the finished map and places nothing. A
// column "check" that says yes gives a name that ending.
bool IsCheckPoint(std::string_view point_name);

// One point seen in one photo.
struct GcpSighting {
  std::string image_name;  // as written; the case of file names often differs from the files
  double pixel_x = 0.0;    // from the outer corner of the first pixel, as the format counts
  double pixel_y = 0.0;
  std::size_t point = 0;  // index into GcpList::points

  bool operator==(const GcpSighting&) const = default;
};

struct GcpPoint {
  std::string name;  // as written, else "gcp1", ... in the order of the file
  geo::LatLon position;
  bool has_position = true;  // false: as written it can be no place, or no system is named
  std::optional<double>
      height_m;             // above the zero of the file's system: the ellipsoid unless it says otherwise
  double x = 0.0, y = 0.0;  // as written, in the file's system
  std::optional<double> height;  // likewise, in the unit of x and y or, with degrees, in metres

  bool operator==(const GcpPoint&) const = default;
};

struct GcpList {
  std::string file_name;
  std::string reference_system;          // as the line above the rows names it; empty: none does
  std::optional<double> system_error_m;  // that its system's place on Earth is known to; nothing: better
  std::vector<GcpPoint> points;
  std::vector<GcpSighting> sightings;
  std::vector<Remark> warnings;
};

bool LooksLikeGcpList(LogBytes head);

// The points that have a place as written. Errors: kUnsupportedFormat (unknown reference system, or none),
// kCorrupt (no row could be read).
Result<GcpList> ParseGcpList(std::string_view name, LogBytes bytes);
Result<GcpList> ReadGcpList(const InputFile& file);

// All points, also of a list that names no system: core/poses/lists judges what they are.
Result<GcpList> ParseWrittenGcpList(std::string_view name, LogBytes bytes);
Result<GcpList> ReadWrittenGcpList(const InputFile& file);

// Without the points that have no place. Errors as of ParseGcpList.
Result<GcpList> OnlyPlaced(GcpList list);

}  // namespace skyquilt::flight
