// Ground control points as ODM lists them (gcp_list.txt): a reference system in the first line, then
// "x y z pixel_x pixel_y image [name]" per sighting, cut at tabs or blanks. A row whose six tabs or more cut
// it may have blanks within its names; one whose image is "-" is a point that no photo is marked with yet.
// Any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/flight/lists/input_file.h"
#include "core/flight/logs/log_bytes.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {

// Stands for the image of a point that is surveyed and not marked yet.
inline constexpr std::string_view kNoImage = "-";

// One point seen in one photo.
struct GcpSighting {
  std::string image_name;  // as written; the case of file names often differs from the files
  double pixel_x = 0.0;    // from the outer corner of the first pixel, as the format counts
  double pixel_y = 0.0;
  std::size_t point = 0;  // index into GcpList::points
};

struct GcpPoint {
  std::string name;  // as written, else "gcp1", ... in the order of the file
  geo::LatLon position;
  std::optional<double>
      height_m;             // above the zero of the file's system: the ellipsoid unless it says otherwise
  double x = 0.0, y = 0.0;  // as written, in the file's system
  std::optional<double> height;  // likewise, in the unit of x and y or, with degrees, in metres
};

struct GcpList {
  std::string file_name;
  std::string reference_system;  // the first line
  std::vector<GcpPoint> points;
  std::vector<GcpSighting> sightings;
  std::vector<std::string> warnings;
};

bool LooksLikeGcpList(LogBytes head);

// Errors: kUnsupportedFormat (unknown reference system), kCorrupt (no row could be read).
Result<GcpList> ParseGcpList(std::string_view name, LogBytes bytes);
Result<GcpList> ReadGcpList(const InputFile& file);

}  // namespace skyquilt::flight
