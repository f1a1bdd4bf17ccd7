// The ways in which recorders write one and the same track, chosen by a seeded generator: each is read right
// to a metre and to its time, whatever prefixes, quotes, orders, marks and hemispheres it has.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/read_log.h"

namespace skyquilt::flight {
namespace {

constexpr int kVariations = 500;
constexpr int kTrackPlaces = 12;

struct Spot {
  int second = 0;  // after 10:20:00 on 2023-04-05
  double lat_deg = 0.0;
  double lon_deg = 0.0;
  double height_m = 0.0;
};

class Variation {
 public:
  explicit Variation(unsigned seed) : random_(seed) {
    const double lat_deg = Uniform(-80.0, 80.0), lon_deg = Uniform(-179.0, 179.0);
    for (int i = 0; i < kTrackPlaces; ++i)
      spots_.push_back({2 * i, lat_deg + i * 2e-5, lon_deg - i * 3e-5, std::round(Uniform(20.0, 900.0))});
  }

  bool Chance() { return Below(2) == 1; }
  unsigned Below(unsigned bound) { return static_cast<unsigned>(random_() % bound); }
  const std::vector<Spot>& spots() const { return spots_; }

  std::string Time(const Spot& spot) {
    const std::string fraction = Chance() ? "" : ".000";
    switch (Below(3)) {
      case 0:
        return fmt::format("2023-04-05T10:20:{:02}{}Z", spot.second, fraction);
      case 1:
        return fmt::format("2023-04-05T12:20:{:02}{}+02:00", spot.second, fraction);
      default:
        return fmt::format("2023-04-05T04:50:{:02}{}-0530", spot.second, fraction);
    }
  }

  std::string Gpx() {
    const std::string prefix = Chance() ? "" : "gpx:", quote = Chance() ? "\"" : "'";
    const std::string point = prefix + (Chance() ? "trkpt" : Chance() ? "rtept" : "wpt");
    const bool comma = Below(4) == 0, cdata = Chance(), lon_first = Chance();
    const auto number = [&](double value) {
      std::string text = fmt::format("{:.7f}", value);
      if (comma) text[text.find('.')] = ',';
      return quote + text + quote;
    };
    std::string text = fmt::format("{}<?xml version='1.0'?>\n<!-- <{}/> -->\n<{}gpx version='1.1'>",
                                   Chance() ? "\xEF\xBB\xBF" : "", point, prefix);
    std::vector<Spot> spots = spots_;
    if (Chance()) std::reverse(spots.begin(), spots.end());
    for (const Spot& spot : spots) {
      const std::string lat = "lat=" + number(spot.lat_deg), lon = "lon =" + number(spot.lon_deg);
      const std::string time = Time(spot);
      text += fmt::format("<{0} {1}\n{2}><{3}ele>{4}</{3}ele><{3}time>{5}</{3}time></{0}>", point,
                          lon_first ? lon : lat, lon_first ? lat : lon, prefix, spot.height_m,
                          cdata ? "<![CDATA[" + time + "]]>" : "&#50;" + time.substr(1));
    }
    return text + fmt::format("</{}gpx>", prefix);
  }

  std::string Kml() {
    const std::string prefix = Chance() ? "" : "kml:";
    std::string body;
    if (Chance()) {
      std::string whens, coords;
      for (const Spot& spot : spots_) {
        const std::string when = fmt::format("<{0}when>{1}</{0}when>", prefix, Time(spot));
        const std::string coord =
            fmt::format("<gx:coord>{:.7f} {:.7f} {}</gx:coord>", spot.lon_deg, spot.lat_deg, spot.height_m);
        whens += when;
        coords += coord;
        body += when + coord;
      }
      if (Chance()) body = whens + coords;
      body = "<gx:Track>" + body + "</gx:Track>";
    } else {
      for (const Spot& spot : spots_) {
        const std::string time =
            fmt::format("<{0}TimeStamp><{0}when>{1}</{0}when></{0}TimeStamp>", prefix, Time(spot));
        const std::string point =
            fmt::format("<{0}Point><{0}coordinates>{1:.7f},{2:.7f},{3}</{0}coordinates></{0}Point>", prefix,
                        spot.lon_deg, spot.lat_deg, spot.height_m);
        body +=
            fmt::format("<{0}Placemark>{1}</{0}Placemark>", prefix, Chance() ? time + point : point + time);
      }
    }
    return fmt::format("<{0}kml xmlns='x'>{1}</{0}kml>", prefix, body);
  }

  std::string GeoJson() {
    constexpr const char* kOfPoints[] = {"time", "timestamp", "datetime", "Date_Time", "UTC"};
    constexpr const char* kOfLines[] = {"coordTimes", "times", "datetimes", "timestamps"};
    const bool is_line = Chance(), counts = Below(3) == 0;
    const std::string name = is_line ? kOfLines[Below(4)] : kOfPoints[Below(5)];
    std::string features, places, times;
    for (const Spot& spot : spots_) {
      const std::string place =
          fmt::format("[{:.7f}, {:.7f}, {}]", spot.lon_deg, spot.lat_deg, spot.height_m);
      const std::string time =
          counts ? fmt::format("{}", 1'680'690'000'000 + spot.second * 1000) : "\"" + Time(spot) + "\"";
      features += (features.empty() ? "" : ",") + Feature("Point", place, name, time);
      places += (places.empty() ? "" : ",") + place;
      times += (times.empty() ? "" : ",") + time;
    }
    if (is_line) features = Feature("LineString", "[" + places + "]", name, "[" + times + "]");
    return R"({"type":"FeatureCollection","features":[)" + features + "]}";
  }

  std::string Nmea() {
    constexpr const char* kTalkers[] = {"GP", "GN", "GL", "BD", "GA"};
    constexpr const char* kBefore[] = {"", "04-05 12:20:00.000 D NMEA : ", "1680690000123;", "[10:20:00] "};
    const std::string talker = kTalkers[Below(5)], before = kBefore[Below(4)];
    const bool has_sums = Chance(), is_rmc_alone = Below(4) == 0;
    std::string text;
    const auto say = [&](const std::string& body) {
      unsigned sum = 0;
      for (const char c : body) sum ^= static_cast<unsigned char>(c);
      text += before + "$" + body + (has_sums ? fmt::format("*{:02X}", sum) : "") + "\r\n";
    };
    for (const Spot& spot : spots_) {
      const auto angle = [](double deg, int width, char plus, char minus) {
        const double size = std::abs(deg), whole = std::floor(size);
        return fmt::format("{:0{}}{:08.5f},{}", static_cast<int>(whole), width, (size - whole) * 60.0,
                           deg < 0.0 ? minus : plus);
      };
      const std::string place = angle(spot.lat_deg, 2, 'N', 'S') + "," + angle(spot.lon_deg, 3, 'E', 'W');
      if (!is_rmc_alone) {
        say(fmt::format("{}GGA,1020{:02}.00,{},1,12,0.7,{:.1f},M,47.0,M,,", talker, spot.second, place,
                        spot.height_m));
      }
      say(fmt::format("{}RMC,1020{:02}.00,A,{},1.0,90.0,050423,,,A", talker, spot.second, place));
    }
    return text;
  }

  std::string Autel() {
    const bool is_ass = Chance(), is_signed = Chance(), lat_first = Chance();
    std::string text = is_ass ? "[Events]\nFormat: Layer, Start, End, Text\n" : "";
    for (const Spot& spot : spots_) {
      const auto axis = [&](double deg, char plus, char minus) {
        return fmt::format("{}: {:.6f}", deg < 0.0 ? minus : plus, is_signed ? deg : std::abs(deg));
      };
      const std::string lat = axis(spot.lat_deg, 'N', 'S'), lon = axis(spot.lon_deg, 'E', 'W');
      const std::string line = is_ass ? "\\N" : "\n";
      const std::string words =
          fmt::format("HOME(1.5, 2.5) 2023.4.5 10:20:{:02}{}GPS({}, {}, {}) ReH:40", spot.second, line,
                      lat_first ? lat : lon, lat_first ? lon : lat, spot.height_m);
      text += is_ass ? fmt::format("Dialogue: 0,0:00:{:02}.00,0:01:00.00,{}\n", spot.second, words)
                     : fmt::format("1\n00:00:{:02},000 --> 00:01:00,000\n{}\n\n", spot.second, words);
    }
    return text;
  }

 private:
  double Uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }

  std::string Feature(const std::string& type, const std::string& places, const std::string& name,
                      const std::string& times) {
    const std::string geometry = fmt::format(R"("geometry":{{"coordinates":{},"type":"{}"}})", places, type);
    const std::string properties = fmt::format(R"("properties":{{"id":7,"{}":{}}})", name, times);
    return "{\"type\":\"Feature\"," + (Chance() ? geometry + "," + properties : properties + "," + geometry) +
           "}";
  }

  std::mt19937 random_;
  std::vector<Spot> spots_;
};

using Write = std::string (Variation::*)();

void ExpectAllRight(std::string_view format, Write write) {
  for (unsigned seed = 0; seed < kVariations; ++seed) {
    Variation variation(seed);
    const std::string text = (variation.*write)();
    const auto log = ParseLog("track", BytesOf(text));
    ASSERT_TRUE(log.ok()) << seed << ": " << log.error().message << "\n" << text;
    if (!format.empty()) {
      ASSERT_EQ(log->format, format) << text;
    }
    ASSERT_EQ(log->gnss.size(), variation.spots().size()) << seed << "\n" << text;
    const auto zero = log->utc_at_zero ? log->utc_at_zero : log->local_at_zero;
    ASSERT_TRUE(zero) << text;
    EXPECT_EQ(*zero, *UtcFromCivil(2023, 4, 5, 10, 20, 0.0)) << seed << "\n" << text;
    for (std::size_t i = 0; i < log->gnss.size(); ++i) {
      const Spot& spot = variation.spots()[i];
      const GnssSample& read = log->gnss[i];
      constexpr double kMetreDeg = 0.9e-5;
      ASSERT_NEAR(read.position.lat_deg, spot.lat_deg, kMetreDeg) << seed << "\n" << text;
      ASSERT_NEAR(read.position.lon_deg, spot.lon_deg, kMetreDeg) << seed << "\n" << text;
      ASSERT_NEAR(read.t_s, spot.second, 1e-6) << seed << "\n" << text;
      if (read.height_amsl_m) {
        ASSERT_NEAR(*read.height_amsl_m, spot.height_m, 0.01) << seed << "\n" << text;
      }
    }
  }
}

TEST(TrackVariations, GpxIsReadRight) { ExpectAllRight("gpx", &Variation::Gpx); }
TEST(TrackVariations, KmlIsReadRight) { ExpectAllRight("kml", &Variation::Kml); }
TEST(TrackVariations, GeoJsonIsReadRight) { ExpectAllRight("geojson", &Variation::GeoJson); }
TEST(TrackVariations, NmeaIsReadRight) { ExpectAllRight("nmea", &Variation::Nmea); }
TEST(TrackVariations, AutelsSubtitlesAreReadRight) { ExpectAllRight("", &Variation::Autel); }

}  // namespace
}  // namespace skyquilt::flight
