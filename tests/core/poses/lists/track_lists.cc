// Logs with times: tables with every way to write dates, GPX, KML, GeoJSON, NMEA behind other stamps,
// subtitles; and events of the shutter in files not named so, with a clock of their own and a row missing.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <functional>

#include "core/geo/geoid.h"
#include "core/geo/local_frame.h"
#include "tests/core/poses/lists/generated_list.h"

namespace skyquilt::testing {
namespace {

constexpr int kTakeoffS = 20, kPhotos = 12, kBetweenPhotosS = 4;
constexpr double kSpeedMps = 4.0, kShutterS = 0.237;  // after a full second, where no fix is

// Five seconds on the ground, a climb to 60 m, then one straight line.
struct Course {
  geo::LocalFrame frame;
  double east_share, north_share, geoid_m;

  geo::Wgs84 At(double t_s) const {
    const double along_m = kSpeedMps * std::max(0.0, t_s - kTakeoffS);
    const double up_m = std::min(60.0, std::max(0.0, 6.0 * (t_s - 5.0)));
    return frame.Wgs84FromEnu({along_m * east_share, along_m * north_share, up_m});
  }
  double AmslM(double t_s) const { return At(t_s).height_ellipsoid_m - geoid_m; }
};

double ExposedAtS(int number) { return kTakeoffS + 2 + number * kBetweenPhotosS + kShutterS; }
constexpr int kTrackS = kTakeoffS + 2 + kPhotos * kBetweenPhotosS + 4;

struct Flown {
  Course course;
  std::int64_t start_unix_s = 0;
  std::tm UtcAt(int t_s) const { return fmt::gmtime(static_cast<std::time_t>(start_unix_s + t_s)); }
  std::string Iso(int t_s) const { return fmt::format("{:%Y-%m-%dT%H:%M:%S}Z", UtcAt(t_s)); }
};

Flown Fly(Dice& dice, GeneratedList& list) {
  const PlaceOnEarth place = AnywhereInDegrees(dice);
  const double geoid_m = geo::GeoidHeightM(place.middle).value_or(0.0);
  const double turn = dice.Between(0.0, 6.28);
  Flown flown{
      {geo::LocalFrame({place.middle.lat_deg, place.middle.lon_deg, geoid_m + dice.Between(20.0, 900.0)}),
       std::cos(turn), std::sin(turn), geoid_m}};
  // A day in the years of drones, between six and sixteen hours; half of the days are no months.
  flown.start_unix_s = 1'420'070'400 + 86'400 * static_cast<std::int64_t>(dice.Below(3'600));
  flown.start_unix_s += 6 * 3'600 + static_cast<std::int64_t>(dice.Below(10 * 3'600));
  const bool is_local = dice.OneIn(2);
  const std::int64_t zone_s = is_local ? 1'800 * (static_cast<std::int64_t>(dice.Below(44)) - 20) : 0;
  for (int k = 0; k < kPhotos; ++k) {
    flight::Photo photo;
    photo.name = fmt::format("IMG_{:04}.JPG", 31 + k);
    photo.camera_key = "one";
    photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3665.0);
    photo.captured_at = flight::UtcTime(std::chrono::microseconds(
        std::llround((static_cast<double>(flown.start_unix_s + zone_s) + ExposedAtS(k)) * 1000.0) * 1000));
    photo.captured_at_is_local = is_local;
    list.photos.push_back(photo);
    list.truth.push_back({photo.name, flown.course.At(ExposedAtS(k)), true});
  }
  list.tolerance_m = 2.0;  // between two fixes, by the smoothed track
  return flown;
}

using Stamp = std::function<std::vector<std::string>(int)>;

// Headers of the columns of time, and what stands in them.
std::pair<std::vector<std::string>, Stamp> ChooseStamp(const Flown& flown, const WayToWrite& way,
                                                       Dice& dice) {
  const auto utc = [flown](int t_s) { return flown.UtcAt(t_s); };
  switch (dice.Below(9)) {
    case 0:
      return {{dice.Of({"timestamp", "time_utc", "utc", "time", "datetime"})},
              [flown](int t) { return std::vector{flown.Iso(t)}; }};
    case 1:
      return {{dice.Of({"datetime(utc)", "Date/Time (UTC)", "UTC time"})},
              [utc](int t) { return std::vector{fmt::format("{:%Y-%m-%d %H:%M:%S}", utc(t))}; }};
    case 2:
      return {{dice.Of({"Date/Time (UTC)", "datetime(utc)"})}, [utc](int t) {
                const std::tm at = utc(t);
                return std::vector{
                    fmt::format("{}/{}/{} {:%I:%M:%S %p}", at.tm_mon + 1, at.tm_mday, at.tm_year + 1900, at)};
              }};
    case 3:
      return {{dice.Of({"Date/Time (UTC)", "datetime(utc)", "time_utc"})},
              [utc](int t) { return std::vector{fmt::format("{:%d.%m.%Y %H:%M:%S}", utc(t))}; }};
    case 4:
      return {{dice.Of({"Date/Time (UTC)", "datetime(utc)"})},
              [utc](int t) { return std::vector{fmt::format("{:%d/%m/%Y %H:%M:%S}", utc(t))}; }};
    case 5:
      return {{"date", "time"}, [utc](int t) {
                return std::vector{fmt::format("{:%Y-%m-%d}", utc(t)), fmt::format("{:%H:%M:%S}", utc(t))};
              }};
    case 6:
      return {{"Date", "Time (UTC)"}, [utc](int t) {
                return std::vector{fmt::format("{:%m/%d/%Y}", utc(t)), fmt::format("{:%I:%M:%S %p}", utc(t))};
              }};
    case 7:
      return {{dice.Of({"timestamp", "time_ms", "epoch_ms", "time (ms)"})},
              [flown](int t) { return std::vector{fmt::format("{}", (flown.start_unix_s + t) * 1000)}; }};
    default:
      return {{dice.Of({"timestamp", "unix_time", "time_s", "epoch"})}, [flown, way](int t) {
                return std::vector{Written(static_cast<double>(flown.start_unix_s + t), 1, way)};
              }};
  }
}

std::string AsTable(const Flown& flown, Dice& dice, GeneratedList& list) {
  const WayToWrite way = ChooseWay(dice);
  const auto [headers, stamp] = ChooseStamp(flown, way, dice);
  const bool in_feet = dice.OneIn(3), longitude_first = dice.OneIn(3), time_last = dice.OneIn(4);
  const auto form = dice.OneIn(3)
                        ? static_cast<DegreeForm>(dice.Below(static_cast<std::size_t>(DegreeForm::kCount)))
                        : DegreeForm::kPlain;
  const auto row_of = [&](std::vector<std::string> times, std::string lat, std::string lon,
                          std::string height) {
    std::vector<std::string> place = {std::move(lat), std::move(lon), std::move(height)};
    if (longitude_first) std::swap(place[0], place[1]);
    std::vector<std::string>& first = time_last ? place : times;
    const std::vector<std::string>& then = time_last ? times : place;
    first.insert(first.end(), then.begin(), then.end());
    return first;
  };
  list.file_name = dice.Of({"track.csv", "log.csv", "telemetry.txt", "flight.tsv"});
  const std::string lat_header = dice.Of({"lat", "latitude", "Latitude"});
  const std::string lon_header = dice.Of({"lon", "longitude", "Longitude"});
  const std::string height_header = in_feet ? "Altitude (ft)" : dice.Of({"alt", "altitude", "Altitude (m)"});
  std::string text = (dice.OneIn(6) ? fmt::format("sep={}\n", way.separator) : "") +
                     Row(row_of(headers, lat_header, lon_header, height_header), way);
  for (int t = 0; t <= kTrackS; ++t) {
    const geo::Wgs84 at = flown.course.At(t);
    const double amsl_m = flown.course.AmslM(t);
    text += Row(row_of(stamp(t), WrittenDegrees(at.lat_deg, true, form, way),
                       WrittenDegrees(at.lon_deg, false, form, way),
                       Written(in_feet ? amsl_m / kMetresPerFoot : amsl_m, 2, way)),
                way);
  }
  return text;
}

std::string AsGpx(const Flown& flown, Dice& dice, GeneratedList& list) {
  list.file_name = "track.gpx";
  const std::string prefix = dice.Of({"", "", "gpx:", "g:"}), point = dice.Of({"trkpt", "trkpt", "rtept"});
  const char quote = dice.OneIn(3) ? '\'' : '"';
  const bool longitude_first = dice.OneIn(3);
  const std::string around = point == "rtept" ? "rte" : "trk",
                    inner = point == "rtept" ? "" : fmt::format("<{}trkseg>", prefix);
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<{0}gpx version=\"1.1\" xmlns{1}=\"http://www.topografix.com/GPX/1/1\"><{0}{2}>{3}\n",
      prefix, prefix.empty() ? "" : ":" + prefix.substr(0, prefix.size() - 1), around, inner);
  for (int t = 0; t <= kTrackS; ++t) {
    const geo::Wgs84 at = flown.course.At(t);
    const std::string lat = fmt::format("lat={0}{1:.8f}{0}", quote, at.lat_deg),
                      lon = fmt::format("lon={0}{1:.8f}{0}", quote, at.lon_deg);
    text += fmt::format("<{0}{1} {2} {3}><{0}ele>{4:.2f}</{0}ele><{0}time>{5}</{0}time></{0}{1}>\n", prefix,
                        point, longitude_first ? lon : lat, longitude_first ? lat : lon,
                        flown.course.AmslM(t), flown.Iso(t));
  }
  return text + fmt::format("{}</{}{}></{}gpx>\n", inner.empty() ? "" : fmt::format("</{}trkseg>", prefix),
                            prefix, around, prefix);
}

std::string AsKml(const Flown& flown, Dice& dice, GeneratedList& list) {
  list.file_name = "track.kml";
  std::string text =
      "<?xml version=\"1.0\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" xmlns:gx=\"http://www.google.com/kml/ext/2.2\"><Placemark><gx:Track>\n";
  std::string whens, coords;
  const bool in_turn = dice.OneIn(2);
  for (int t = 0; t <= kTrackS; ++t) {
    const geo::Wgs84 at = flown.course.At(t);
    const std::string when = fmt::format("<when>{}</when>\n", flown.Iso(t));
    const std::string coord = fmt::format("<gx:coord>{:.8f} {:.8f} {:.2f}</gx:coord>\n", at.lon_deg,
                                          at.lat_deg, flown.course.AmslM(t));
    if (in_turn) text += when + coord;
    whens += when, coords += coord;
  }
  if (!in_turn) text += whens + coords;
  return text + "</gx:Track></Placemark></kml>\n";
}

std::string AsGeoJson(const Flown& flown, Dice& dice, GeneratedList& list) {
  list.file_name = dice.Of({"track.geojson", "track.json"});
  const bool as_points = dice.OneIn(2);
  std::string places, times, points;
  for (int t = 0; t <= kTrackS; ++t) {
    const geo::Wgs84 at = flown.course.At(t);
    const std::string place =
        fmt::format("[{:.8f},{:.8f},{:.2f}]", at.lon_deg, at.lat_deg, flown.course.AmslM(t));
    const std::string comma = t == 0 ? "" : ",\n";
    places += comma + place;
    times += fmt::format("{}\"{}\"", comma, flown.Iso(t));
    points += fmt::format(
        "{}{{\"type\":\"Feature\",\"properties\":{{\"time\":\"{}\"}},\"geometry\":{{\"type\":\"Point\",\"coordinates\":{}}}}}",
        comma, flown.Iso(t), place);
  }
  if (as_points) return "{\"type\":\"FeatureCollection\",\"features\":[" + points + "]}\n";
  return "{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\",\"properties\":{\"coordTimes\":[" +
         times + "]},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[" + places + "]}}]}\n";
}

std::string NmeaDegrees(double degrees, int width, std::string_view letters) {
  const double size = std::abs(degrees), whole = std::floor(size);
  return fmt::format("{:0{}d}{:010.7f},{}", static_cast<int>(whole), width, (size - whole) * 60.0,
                     letters[degrees < 0 ? 1 : 0]);
}

std::string AsNmea(const Flown& flown, Dice& dice, GeneratedList& list) {
  list.file_name = dice.Of({"track.nmea", "gps.log", "nmea.txt"});
  const std::size_t stamp = dice.Below(4);
  const bool with_checksums = dice.OneIn(2);
  const std::string talker = dice.Of({"GP", "GN"});
  std::string text;
  for (int t = 0; t <= kTrackS; ++t) {
    const geo::Wgs84 at = flown.course.At(t);
    const std::tm utc = flown.UtcAt(t);
    const std::string place = NmeaDegrees(at.lat_deg, 2, "NS") + "," + NmeaDegrees(at.lon_deg, 3, "EW");
    const std::string sentences[] = {
        fmt::format("{}RMC,{:%H%M%S}.00,A,{},7.8,90.0,{:%d%m%y},,,A", talker, utc, place, utc),
        fmt::format("{}GGA,{:%H%M%S}.00,{},1,12,0.7,{:.2f},M,{:.2f},M,,", talker, utc, place,
                    flown.course.AmslM(t), flown.course.geoid_m)};
    for (const std::string& sentence : sentences) {
      if (stamp == 1) text += fmt::format("{:%Y-%m-%d %H:%M:%S}.120 ", utc);
      if (stamp == 2) text += fmt::format("{:%m-%d %H:%M:%S}.120  1234  1250 D NmeaLog: ", utc);
      if (stamp == 3) text += fmt::format("[{}] ", (flown.start_unix_s + t) * 1000);
      text += "$" + sentence;
      unsigned checksum = 0;
      for (const char c : sentence) checksum ^= static_cast<unsigned char>(c);
      text += with_checksums ? fmt::format("*{:02X}\n", checksum) : "\n";
    }
  }
  return text;
}

// A row a photo, known to centimetres, by a receiver whose clock nobody compared with the camera's.
std::string AsEvents(const Flown& flown, Dice& dice, GeneratedList& list) {
  // An even rhythm would leave open which row is missing.
  double at_s = kTakeoffS + 2.0;
  const double ahead_s = dice.Between(-9'000.0, 9'000.0);
  const std::size_t missing = dice.OneIn(2) ? dice.Below(list.photos.size()) : list.photos.size();
  const bool is_table = dice.OneIn(2);
  list.file_name =
      is_table ? "reach_events.csv" : dice.Of({"raw_UBX_events.pos", "events.pos", "camera.pos"});
  std::string text =
      is_table
          ? "name,time,longitude,latitude,ellipsoidal height,fix\n"
          : "% program   : RTKLIB\n%  GPST                  latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)\n";
  for (std::size_t k = 0; k < list.photos.size(); ++k) {
    at_s += 2.0 + dice.Between(0.0, 6.0);
    const std::int64_t unix_ms = flown.start_unix_s * 1000 + std::llround(at_s * 1000.0);
    list.photos[k].captured_at = flight::UtcTime(std::chrono::milliseconds(unix_ms));
    list.truth[k].at = flown.course.At(at_s);
    list.truth[k].has_row = k != missing;
    if (k == missing) continue;
    const std::int64_t row_ms = unix_ms + std::llround(ahead_s * 1000.0);
    const std::tm row = fmt::gmtime(static_cast<std::time_t>(row_ms / 1000));
    const geo::Wgs84& at = list.truth[k].at;
    text +=
        is_table
            ? fmt::format("{},{:%Y-%m-%d %H:%M:%S}.{:03},{:.9f},{:.9f},{:.4f},FIX\n", k + 1, row,
                          row_ms % 1000, at.lon_deg, at.lat_deg, at.height_ellipsoid_m)
            : fmt::format(
                  "{:%Y/%m/%d %H:%M:%S}.{:03}   {:.9f}  {:.9f}   {:.4f}   1  14   0.0081   0.0070   0.0190\n",
                  row, row_ms % 1000, at.lat_deg, at.lon_deg, at.height_ellipsoid_m);
  }
  list.tolerance_m = 1.0;
  return text;
}

}  // namespace

GeneratedList GenerateTrack(std::uint32_t seed) {
  Dice dice(seed);
  GeneratedList list;
  const Flown flown = Fly(dice, list);
  list.causes = {"time", "clock", "line ",    "date",      "column",
                 "row",  "event", "latitude", "longitude", "track point"};
  // Tables come in most ways.
  constexpr std::array kWriters = {AsTable, AsTable, AsTable, AsGpx, AsKml, AsGeoJson, AsNmea, AsEvents};
  list.text = kWriters[dice.Below(kWriters.size())](flown, dice, list);
  // XML says its encoding itself.
  list.bytes = list.text.starts_with("<?xml") ? list.text : Encoded(list.text, dice);
  return list;
}

}  // namespace skyquilt::testing
