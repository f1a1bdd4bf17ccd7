#include <algorithm>
#include <array>
#include <utility>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/number_cell.h"
#include "core/flight/logs/tracks/track_points.h"
#include "core/flight/logs/tracks/xml_scanner.h"
#include "core/flight/remarks/because.h"

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

namespace {

constexpr std::size_t kLongestTime = 64;

class KmlReader {
 public:
  explicit KmlReader(TrackPoints& points) : points_(points) {}

  void Open(std::string_view name) {
    if (name == "MultiTrack") {
      in_multi_track_ = true;
      mode_of_tracks_.clear();
    } else if (name == "Track") {
      in_track_ = true;
      whens_.clear();
      coords_.clear();
      mode_ = mode_of_tracks_;
    } else if (name == "Placemark") {
      time_.clear();
      place_.clear();
    } else if (name == "Point" || name == "LineString" || name == "LinearRing") {
      in_point_ = name == "Point";
      mode_.clear();
    }
  }

  void Close(std::string_view name, std::string_view words) {
    if (name == "altitudeMode") {
      mode_ = words;
      if (in_multi_track_ && !in_track_) mode_of_tracks_ = words;
    } else if (name == "MultiTrack") {
      in_multi_track_ = false;
      mode_of_tracks_.clear();
    } else if (name == "coord" && in_track_) {
      if (coords_.size() < kMaxTrackPoints) coords_.push_back(PointOf(words, false));
    } else if (name == "when" && in_track_) {
      if (whens_.size() < kMaxTrackPoints) whens_.emplace_back(words.substr(0, kLongestTime));
    } else if (name == "Track") {
      TakeTrack();
    } else if ((name == "when" || name == "begin") && time_.empty()) {
      time_ = words;
    } else if (name == "coordinates" && in_point_) {
      place_ = words;
    } else if (name == "coordinates") {
      ++shapes_;
    } else if (name == "Placemark" && !place_.empty()) {
      points_.Add(WithHeight(PointOf(place_, true)), time_);
      place_.clear();
    }
  }

  std::uint64_t shapes() const { return shapes_; }

 private:
  // "lon,lat,height" of a Point, "lon lat height" of a track.
  std::optional<TrackPoint> PointOf(std::string_view words, bool has_commas) {
    if (has_commas)
      SplitFields(words, ',', parts_);
    else
      SplitBlanks(words, parts_);
    if (parts_.size() < 2) return std::nullopt;
    const auto lon = ParseNumber(parts_[0]);
    const auto lat = ParseNumber(parts_[1]);
    if (!lon || !lat) return std::nullopt;
    return TrackPoint{*lat, *lon, parts_.size() > 2 ? ParseNumber(parts_[2]) : std::nullopt, {}, {}};
  }

  // What altitudeMode says of a height. Programs that have none write 0 and no mode.
  std::optional<TrackPoint> WithHeight(std::optional<TrackPoint> point) const {
    if (!point) return point;
    if (mode_.starts_with("relative")) std::swap(point->height_amsl_m, point->height_above_takeoff_m);
    if (mode_.starts_with("clamp") || (mode_.empty() && point->height_amsl_m == 0.0))
      point->height_amsl_m.reset();
    return point;
  }

  void TakeTrack() {
    in_track_ = false;
    for (std::size_t i = 0; i < std::max(whens_.size(), coords_.size()); ++i) {
      points_.Add(i < coords_.size() ? WithHeight(coords_[i]) : std::nullopt,
                  i < whens_.size() ? std::string_view(whens_[i]) : std::string_view());
    }
    whens_ = {};
    coords_ = {};
  }

  TrackPoints& points_;
  std::vector<std::string_view> parts_;
  bool in_track_ = false;
  bool in_multi_track_ = false;
  bool in_point_ = false;
  std::string mode_;
  std::string mode_of_tracks_;  // of those in a MultiTrack, which may say it for all of them
  std::vector<std::string> whens_;
  std::vector<std::optional<TrackPoint>> coords_;
  std::string time_;   // of the Placemark
  std::string place_;  // of its Point
  std::uint64_t shapes_ = 0;
};

}  // namespace

bool LooksLikeKml(LogBytes head) { return XmlRootName(TextOf(head)) == "kml"; }

Result<FlightLog> ParseKml(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  TrackPoints points("kml", name, TrackPoints::BareTime::kLocal);
  KmlReader reader(points);
  XmlScanner xml(TextOf(bytes));
  ConsumedSteps steps(consumed);
  while (xml.Next()) {
    steps.At(xml.offset());
    if (xml.opens())
      reader.Open(xml.name());
    else
      reader.Close(xml.name(), xml.words());
  }
  const bool has_points = points.count() > 0;
  auto log =
      std::move(points).Finish({"altitude -> height above mean sea level, m; above take-off where "
                                "altitudeMode is relative"});
  if (has_points || reader.shapes() == 0) return log;
  return Because(ErrorCode::kNoPosition,
                 {RemarkCode::kShapesWithoutTimes, {{"file", name}, {"shapes", reader.shapes()}}},
                 log.error().detail);
}

}  // namespace skyquilt::flight
