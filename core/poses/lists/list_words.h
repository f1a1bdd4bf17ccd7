// What is said of the lists of a flight. Pure; any thread.
#pragma once

#include <optional>
#include <string>

#include "core/flight/lists/list_use.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::poses {

// "longitude, latitude in degrees": what the two numbers were taken for.
std::string ReadingInWords(const flight::ListUse& use, const flight::ListReading& reading);

// One line for a verdict: "geo.txt (geo_txt): read as ..., 18 of 18 rows used, 4.0 m from ...".
std::string UseInWords(const flight::ListUse& use);

// What the user is to know before the map is believed; nothing where the list is as it should be, or where
// its rows name no photo (ApplyPhotoRows says that).
std::optional<flight::Remark> RemarkOf(const flight::ListUse& use);

// That its system's own place on Earth is not known well; nothing where it is, or the list does not serve.
std::optional<flight::Remark> RemarkOnSystem(const flight::ListUse& use);

// That its coordinates are written in a coarse step; nothing where they are not, or the list does not serve.
std::optional<flight::Remark> RemarkOnRounding(const flight::ListUse& use);

// That its places lie where numbers of another unit do; nothing where others say where the flight was.
std::optional<flight::Remark> RemarkOnUnit(const flight::ListUse& use,
                                           const std::optional<geo::LatLon>& middle);

// That its places lie in the southern half where those of band S do; nothing where others say where it was.
std::optional<flight::Remark> RemarkOnHalf(const flight::ListUse& use,
                                           const std::optional<geo::LatLon>& middle);

// The question of a list that two readings fit.
std::string QuestionOf(const flight::ListUse& use, const geo::LatLon& as_read,
                       const flight::ListReading& other, const geo::LatLon& as_other);

}  // namespace skyquilt::poses
