#include "core/flight/logs/tracks/gpx.h"

#include <algorithm>
#include <array>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/number_cell.h"
#include "core/flight/logs/tracks/track_points.h"
#include "core/flight/logs/tracks/xml_scanner.h"

namespace skyquilt::flight {
namespace {

// In the order of preference.
constexpr std::array<std::string_view, 3> kGpxPoints = {"trkpt", "rtept", "wpt"};

struct GpxPoint {
  std::size_t kind = 0;
  std::optional<double> lat_deg;
  std::optional<double> lon_deg;
  std::optional<double> height_amsl_m;
  std::optional<double> geoid_above_ellipsoid_m;
  std::string time;
};

// Calls `take` with each point of any kind. What programs add (<extensions>) may use the same names.
template <typename Take>
void ForEachGpxPoint(LogBytes bytes, const ConsumedUpTo& consumed, Take take) {
  XmlScanner xml(TextOf(bytes));
  ConsumedSteps steps(consumed);
  std::optional<GpxPoint> point;
  bool in_extensions = false;
  while (xml.Next()) {
    steps.At(xml.offset());
    const auto kind = static_cast<std::size_t>(std::find(kGpxPoints.begin(), kGpxPoints.end(), xml.name()) -
                                               kGpxPoints.begin());
    if (kind < kGpxPoints.size()) {
      if (point) take(*point);  // also one that was never closed
      point.reset();
      in_extensions = false;
      if (!xml.opens()) continue;
      point = GpxPoint{kind, {}, {}, {}, {}, {}};
      if (const auto lat = xml.Attribute("lat")) point->lat_deg = ReadBareNumber(*lat);
      if (const auto lon = xml.Attribute("lon")) point->lon_deg = ReadBareNumber(*lon);
    } else if (xml.name() == "extensions") {
      in_extensions = xml.opens();
    } else if (point && !xml.opens() && !in_extensions) {
      if (xml.name() == "time") point->time = xml.words();
      if (xml.name() == "ele") point->height_amsl_m = ReadBareNumber(xml.words());
      if (xml.name() == "geoidheight") point->geoid_above_ellipsoid_m = ReadBareNumber(xml.words());
    }
  }
  if (point) take(*point);
}

}  // namespace

bool LooksLikeGpx(LogBytes head) { return XmlRootName(TextOf(head)) == "gpx"; }

Result<FlightLog> ParseGpx(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  std::array<std::uint64_t, kGpxPoints.size()> timed{};
  std::array<std::uint64_t, kGpxPoints.size()> all{};
  ForEachGpxPoint(bytes, consumed, [&](const GpxPoint& point) {
    ++all[point.kind];
    if (point.lat_deg && point.lon_deg && TrackTime(point.time)) ++timed[point.kind];
  });
  // Where none is timed, the first kind that is there says why.
  const auto is_there = [](std::uint64_t count) { return count > 0; };
  auto taken = static_cast<std::size_t>(std::find_if(timed.begin(), timed.end(), is_there) - timed.begin());
  if (taken == timed.size())
    taken = static_cast<std::size_t>(std::find_if(all.begin(), all.end(), is_there) - all.begin());
  TrackPoints points("gpx", name, TrackPoints::BareTime::kUtc);
  ForEachGpxPoint(bytes, consumed, [&](const GpxPoint& read) {
    if (read.kind != taken) return;
    std::optional<TrackPoint> point;
    if (read.lat_deg && read.lon_deg) {
      point = TrackPoint{*read.lat_deg, *read.lon_deg, read.height_amsl_m, {}, {}};
      if (read.height_amsl_m && read.geoid_above_ellipsoid_m)
        point->height_ellipsoid_m = *read.height_amsl_m + *read.geoid_above_ellipsoid_m;
    }
    points.Add(point, read.time);
  });
  return std::move(points).Finish({});
}

}  // namespace skyquilt::flight
