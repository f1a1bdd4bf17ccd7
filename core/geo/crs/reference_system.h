// ReferenceSystem: coordinates of lists in any horizontal system, brought to WGS84, by the line that names
// it: "EPSG:32616" (also "epsg 32616", "EPSG:32616+5773", URNs), "WGS84 UTM 16N", "wgs84 utm zone 16 north",
// "33U" of MGRS, "ETRS89 / UTM zone 32N" and any other name that PROJ knows, WKT, "+proj=..." strings. Of a
// compound system the horizontal part places, the vertical one tells the unit of heights. Through PROJ,
// without network; strings that name grid files or pipelines are refused. Any thread. PROJ looks up to a
// tenth of a second through its database for one system: the last ones stay at hand. Errors:
// kUnsupportedFormat for a line that names none.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::geo {

// In degrees; east is above 180 where the area crosses the date line.
struct AreaOfUse {
  double west_deg = -180.0, south_deg = -90.0, east_deg = 180.0, north_deg = 90.0;

  bool Contains(const LatLon& place, double margin_deg) const;
};

// How well it is known where an older datum lies on Earth.
struct InexactShift {
  double error_m = 0.0;     // of the best operation that is installed, as PROJ has it
  bool lacks_grid = false;  // a better one needs a grid file that is not installed
};

// A code of EPSG, where it stands in a line.
struct EpsgCode {
  std::size_t begin = 0, length = 0;
  std::string definition;  // "EPSG:32615", "EPSG:32615+5773"; empty: it can be none of its codes
};
// Of a line in small letters: "epsg:32615", "epsg 32615+5773", "epsg-code: 32615", in URNs and URLs with the
// version of the register or without. Nothing where it holds none.
std::optional<EpsgCode> FindEpsgCode(const std::string& lower);

class ReferenceSystem {
 public:
  static Result<ReferenceSystem> Parse(std::string_view line);

  // x is east or longitude, y north or latitude, in the unit of the system, whatever order its authority has
  // them in. Absent where the system has no such place.
  std::optional<LatLon> ToLatLon(double x, double y) const;

  // Nothing where a metre or better is known, and of frames that stand for WGS84 (ETRS89, NAD83, GDA94): what
  // these lie apart, receivers with corrections share with the survey.
  std::optional<InexactShift> InexactShiftAt(double x, double y) const;
  // The error of that around a place on Earth.
  std::optional<double> InexactShiftM(const LatLon& near) const;

  bool is_geographic() const;  // in degrees
  // Heights of lists are in the unit of x and y, and above the ellipsoid, unless the system says otherwise.
  double metres_per_height_unit() const;
  bool heights_are_above_sea() const;
  const AreaOfUse& area() const;  // the whole Earth where PROJ knows none
  // By which the same system is found again at once: its code where it has one, else as written.
  const std::string& definition() const;
  const std::string& name() const;  // as written

 private:
  struct Impl;
  explicit ReferenceSystem(std::shared_ptr<const Impl> impl);
  std::shared_ptr<const Impl> impl_;
};

// WGS84's UTM zone of a place, as a code of EPSG (32601 to 32660, 32701 to 32760), with the exceptions of
// Norway and Svalbard.
int UtmCodeOf(const LatLon& place);
// Whether UTM is defined there: from 80 degrees south to 84 north.
bool IsWithinUtm(const LatLon& place);

}  // namespace skyquilt::geo
