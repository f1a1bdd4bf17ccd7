// Position and heights out of EXIF and XMP, each height under its own zero. Any thread.
// The position is EXIF's (it is what other programs correct); XMP fills in where EXIF has none, lacks a
// hemisphere, or is written in coarser steps. Heights: drone-dji AbsoluteAltitude is above sea level, with
// RTK above the ellipsoid; RelativeAltitude is above take-off, and so is xmp:GPSAltitude of Yuneec's CGO3+;
// EXIF's GPSAltitude counts only when nothing contradicts it, from the ellipsoid where Camera:VertCS says so
// or the maker does (senseFly, Skydio X10, ANAFI Ai), else from the sea, as drone-skydio:GpsMslHeight is.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/metadata/exif.h"
#include "core/flight/metadata/xmp.h"

namespace skyquilt::flight {

std::optional<double> HeightAboveTakeoffFromTags(const XmpTags& xmp);

std::optional<RecordedPosition> PositionFromTags(const ExifRecord& exif, const XmpTags& xmp,
                                                 std::vector<Remark>& notes);

// Nothing where one of them does not say both place and altitude (0 is none).
std::optional<ExifBesideXmp> ExifBesideXmpFromTags(const ExifRecord& exif, const XmpTags& xmp);

}  // namespace skyquilt::flight
