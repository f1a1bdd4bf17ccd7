// Tables as programs and spreadsheets of many countries write them: read right to a metre, or the cell is
// named.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/explain_unknown.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

struct Place {
  double lat_deg, lon_deg, height_m;
};
constexpr std::array kPlaces = {Place{46.84260708, -91.99455989, 198.309},
                                Place{46.84269067, -91.99442728, 198.609},
                                Place{46.84277758, -91.99429939, 1198.4}};

FlightLog Parse(const std::string& text) {
  auto log = ParseLog("list.csv", BytesOf(text));
  EXPECT_TRUE(log.ok()) << (log ? "" : log.error().message) << "\n" << text;
  return log ? *std::move(log) : FlightLog();
}

std::string Refusal(const std::string& text) {
  const auto log = ParseLog("list.csv", BytesOf(text));
  EXPECT_FALSE(log.ok()) << text;
  if (log.ok()) return "";
  EXPECT_TRUE(HasReason(log.error())) << log.error().message;
  return log.error().message;
}

void ExpectPlaces(const FlightLog& log, const std::string& text) {
  ASSERT_EQ(log.events.size(), kPlaces.size()) << text;
  for (std::size_t i = 0; i < kPlaces.size(); ++i) {
    const CameraEvent& event = log.events[i];
    ASSERT_TRUE(event.position) << text << "\n" << ::testing::PrintToString(InWords(log.warnings));
    EXPECT_NEAR(event.position->lat_deg, kPlaces[i].lat_deg, 5e-6) << text;
    EXPECT_NEAR(event.position->lon_deg, kPlaces[i].lon_deg, 5e-6) << text;
    const auto height_m = event.height_amsl_m ? event.height_amsl_m : event.height_ellipsoid_m;
    ASSERT_TRUE(height_m) << text << "\n" << ::testing::PrintToString(InWords(log.warnings));
    EXPECT_NEAR(*height_m, kPlaces[i].height_m, 0.5) << text;
  }
}

// One list a seed: order of columns, separator, encoding, hemispheres, decimal marks, units, names.
class WrittenList {
 public:
  explicit WrittenList(unsigned seed) : random_(seed) {
    separator_ = Pick<char>({',', ';', '\t', '|'});
    decimal_ = Pick<char>({'.', ','});
    in_feet_ = Pick<int>({0, 1}) == 1;
    style_ = Pick<int>({0, 1, 2, 3, 4, 5, 6, 7});
    unit_behind_ = Pick<int>({0, 1}) == 1;
    thousands_ = Pick<int>({0, 0, 1}) == 1;
    encoding_ = Pick<int>({0, 1, 2, 3});
    std::shuffle(order_.begin(), order_.end(), random_);
  }

  std::string Text() {
    const auto names =
        Pick<std::array<const char*, 4>>({{"image", "latitude", "longitude", "altitude"},
                                          {"Image Name", "Latitude", "Longitude", "Altitude MSL"},
                                          {"SourceFile", "GPSLatitude", "GPSLongitude", "GPSAltitude"},
                                          {"Filename", "Lat", "Lng", "Alt"},
                                          {"Dateiname", "Breite", "L\xC3\xA4nge", "H\xC3\xB6he"},
                                          {"fichier", "Latitude", "Longitude", "Altitude"},
                                          {"Imagen", "Latitud", "Longitud", "Altitud"},
                                          {"Label", "Y/Latitude", "X/Longitude", "Z/Altitude"},
                                          {"photo", "lat", "lon", "elevation"}});
    const std::string unit =
        in_feet_ ? Pick<std::string>({" (ft)", " [ft]", " (feet)"}) : Pick<std::string>({"", " (m)"});
    const std::string degrees = Pick<std::string>({"", " (deg)", " [\xC2\xB0]", " (WGS84)"});
    std::string text =
        Line({names[0], names[1] + degrees, names[2] + degrees, names[3] + (unit_behind_ ? "" : unit)});
    for (std::size_t i = 0; i < kPlaces.size(); ++i) {
      const Place& place = kPlaces[i];
      const std::string height = Number(in_feet_ ? place.height_m / 0.3048 : place.height_m, 2, thousands_);
      text +=
          Line({"DJI_00" + std::to_string(18 + i) + ".JPG", Angle(place.lat_deg, 'N', 'S'),
                Angle(place.lon_deg, 'E', 'W'), height + (unit_behind_ ? (in_feet_ ? " ft" : " m") : "")});
    }
    return Encoded(text);
  }

 private:
  template <typename T>
  T Pick(std::vector<T> choices) {
    return choices[random_() % choices.size()];
  }

  std::string Number(double value, int places, bool with_thousands) const {
    char digits[64];
    std::snprintf(digits, sizeof digits, "%.*f", places, value);
    std::string text = digits;
    const std::size_t point = text.find('.');
    text[point] = decimal_;
    if (with_thousands && std::abs(value) >= 1000.0) text.insert(point - 3, 1, decimal_ == '.' ? ',' : '.');
    return text;
  }

  std::string Angle(double value, char positive, char negative) const {
    const double size = std::abs(value);
    const std::string letter(1, value < 0.0 ? negative : positive);
    const std::string sign = value < 0.0 ? "-" : "";
    const int degrees = static_cast<int>(size);
    const int minutes = static_cast<int>((size - degrees) * 60.0);
    const std::string seconds = Number(((size - degrees) * 60.0 - minutes) * 60.0, 3, false);
    const std::string d = std::to_string(degrees), m = std::to_string(minutes);
    switch (style_) {
      case 0:
        return sign + Number(size, 8, false);
      case 1:
        return letter + Number(size, 8, false);
      case 2:
        return Number(size, 8, false) + letter;
      case 3:
        return sign + Number(size, 8, false) + "\xC2\xB0";
      case 4:
        return letter + d + "\xC2\xB0" + m + "'" + seconds + "\"";
      case 5:
        return d + " deg " + m + "' " + seconds + "\" " + letter;
      case 6:
        return d + " " + m + " " + seconds + " " + letter;
      default:
        return sign + d + "\xC2\xB0" + m + "\xE2\x80\xB2" + seconds + "\xE2\x80\xB3";
    }
  }

  std::string Line(const std::array<std::string, 4>& cells) const {
    std::string line;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      std::string cell = cells[order_[i]];
      if (cell.find_first_of(std::string("\"") + separator_) != std::string::npos) {
        for (std::size_t at = cell.find('"'); at != std::string::npos; at = cell.find('"', at + 2))
          cell.insert(at, 1, '"');
        cell = '"' + cell + '"';
      }
      line += (i == 0 ? "" : std::string(1, separator_)) + cell;
    }
    return line + "\r\n";
  }

  // Letters of UTF-8 up to three bytes.
  std::string Encoded(const std::string& text) const {
    if (encoding_ == 0) return text;
    if (encoding_ == 1) return "\xEF\xBB\xBF" + text;
    std::string bytes;
    const auto put = [&](unsigned unit) {
      const char low = static_cast<char>(unit & 0xFFU), high = static_cast<char>(unit >> 8U);
      bytes += encoding_ == 2 ? low : high;
      bytes += encoding_ == 2 ? high : low;
    };
    put(0xFEFF);
    for (std::size_t i = 0; i < text.size();) {
      const auto byte = [&](std::size_t k) {
        return static_cast<unsigned>(static_cast<unsigned char>(text[i + k]));
      };
      const std::size_t length = byte(0) < 0x80 ? 1 : byte(0) < 0xE0 ? 2 : 3;
      put(length == 1   ? byte(0)
          : length == 2 ? ((byte(0) & 0x1FU) << 6U) | (byte(1) & 0x3FU)
                        : ((byte(0) & 0x0FU) << 12U) | ((byte(1) & 0x3FU) << 6U) | (byte(2) & 0x3FU));
      i += length;
    }
    return bytes;
  }

  std::mt19937 random_;
  char separator_ = ',', decimal_ = '.';
  bool in_feet_ = false, unit_behind_ = false, thousands_ = false;
  int style_ = 0, encoding_ = 0;
  std::array<std::size_t, 4> order_{0, 1, 2, 3};
};

TEST(WrittenTables, ReadsFiveHundredListsToAMetre) {
  for (unsigned seed = 0; seed < 500; ++seed) {
    const std::string text = WrittenList(seed).Text();
    ExpectPlaces(Parse(text), fmt::format("seed {}\n{}", seed, text));
    if (HasFatalFailure() || HasNonfatalFailure()) return;
  }
}

TEST(WrittenTables, KeepsWhatWasWrittenWhereItCanBeNoPlace) {
  const FlightLog log = Parse("image,latitude,longitude,altitude\na.jpg,-91.99455989,46.84260708,198.3\n");
  ASSERT_EQ(log.events.size(), 1u);
  EXPECT_FALSE(log.events[0].position);
  ASSERT_TRUE(log.events[0].written);
  EXPECT_DOUBLE_EQ(log.events[0].written->x, 46.84260708);
  EXPECT_DOUBLE_EQ(log.events[0].written->y, -91.99455989);
  EXPECT_TRUE(log.written_order_is_named);
}

TEST(WrittenTables, TakesTheOrderOfItsNames) {
  const FlightLog log = Parse("image,longitude,latitude,altitude\na.jpg,8.0054927,46.84260708,198.3\n");
  ASSERT_EQ(log.events.size(), 1u);
  EXPECT_DOUBLE_EQ(log.events[0].position->lat_deg, 46.84260708);
  EXPECT_DOUBLE_EQ(log.events[0].written->x, 8.0054927);
}

TEST(WrittenTables, AppliesLettersInColumnsOfTheirOwn) {
  const FlightLog log = Parse(
      "SourceFile,GPSLatitude,GPSLatitudeRef,GPSLongitude,GPSLongitudeRef\na.jpg,46.8,North,91.9,West\n"
      "b.jpg,46.8,N,-91.9,W\nc.jpg,46.8,N,-91.9,E\n");
  ASSERT_EQ(log.events.size(), 3u);
  EXPECT_DOUBLE_EQ(log.events[0].position->lon_deg, -91.9);
  EXPECT_DOUBLE_EQ(log.events[1].position->lon_deg, -91.9);
  EXPECT_FALSE(log.events[2].position) << "a minus beside E";
}

TEST(WrittenTables, NamesTheCellsItCannotRead) {
  const FlightLog one =
      Parse("image;latitude;longitude\na.jpg;46,8;8,1\nb.jpg;46 Grad;8,2\nc.jpg;north;8,3\nd.jpg;?;8,4\n");
  EXPECT_THAT(InWords(one.warnings),
              Contains("line 4: column \"latitude\" holds \"north\", which cannot be read as latitude"));
  const FlightLog none = Parse("image;latitude;longitude\na.jpg;46.8x;8,1\nb.jpg;46.9x;8,2\n");
  ASSERT_EQ(none.events.size(), 2u);
  EXPECT_THAT(InWords(none.warnings), Contains(AllOf(HasSubstr("none of the 2 cells of column \"latitude\""),
                                                     HasSubstr("in line 2, is \"46.8x\""),
                                                     HasSubstr("46\xC2\xB0"
                                                               "50'33.4\" N"))));
  std::string many = "image;latitude;longitude\nok.jpg;46.8;8.1\n";
  for (int i = 0; i < 1000; ++i) many += fmt::format("{}.jpg;abc;8.1\n", i);
  const FlightLog bounded = Parse(many);
  EXPECT_EQ(bounded.warnings.size(), 4u);
  EXPECT_THAT(InWords(bounded.warnings), Contains("997 more cells of column \"latitude\" cannot be read"));
}

TEST(WrittenTables, RefusesDecimalCommasBetweenCommas) {
  const std::string why = Refusal("image,latitude,longitude,altitude\na.jpg,46,8426,-91,9945,198,3\n");
  EXPECT_THAT(why, HasSubstr("7 cells in line 2 below 4 names"));
  EXPECT_THAT(why, HasSubstr("semicolons"));
}

TEST(WrittenTables, DoesNotGuessWhatALoneMarkMeans) {
  const FlightLog log = Parse("image;lat;lng;alt\na.jpg;46.8426;8.1;1,234\nb.jpg;46.8426;8.1;1,235\n");
  ASSERT_EQ(log.events.size(), 2u);
  EXPECT_FALSE(log.events[0].height_amsl_m);
  EXPECT_THAT(InWords(log.warnings), Contains(HasSubstr("is \"1,234\"")));
}

TEST(WrittenTables, ReadsHeightsByTheWordsBesideTheirUnit) {
  const auto height = [](const std::string& name, const std::string& cell) {
    return Parse("image;lat;lng;" + name + "\na.jpg;46.8426;8.1;" + cell + "\n").events.at(0);
  };
  EXPECT_NEAR(*height("Altitude (ft AMSL)", "1000").height_amsl_m, 304.8, 1e-9);
  EXPECT_NEAR(*height("Altitude (AMSL) [ft]", "1000").height_amsl_m, 304.8, 1e-9);
  EXPECT_NEAR(*height("Altitude (ellipsoidal)", "1000").height_ellipsoid_m, 1000.0, 1e-9);
  EXPECT_NEAR(*height("Ellipsoidal height", "1000").height_ellipsoid_m, 1000.0, 1e-9);
  EXPECT_NEAR(*height("Altitude", "1000 ft").height_ellipsoid_m, 304.8, 1e-9);
  for (const char* name : {"Altitude (m NAVD88)", "H\xC3\xB6he (m \xC3\xBC. NHN)", "H\xF6he (m \xFC. M.)",
                           "Elevation (m)_EGM96", "height_navd88", "Altitude (meters above mean sea level)"})
    EXPECT_EQ(height(name, "1000").height_amsl_m, 1000.0) << name;
  EXPECT_NEAR(*height("Ellipsoidal Height (sft)", "3937").height_ellipsoid_m, 1200.0, 1e-9);
  EXPECT_NEAR(*height("elevation (US survey ft)", "3937").height_ellipsoid_m, 1200.0, 1e-9);
}

TEST(WrittenTables, SaysWhichColumnIsNotReadForAWord) {
  const FlightLog log =
      Parse("image;lat;lng;Altitude (furlongs);omega [mils];phi;kappa\na.jpg;46.8426;8.1;5;1;2;3\n");
  EXPECT_FALSE(log.events.at(0).height_amsl_m || log.events.at(0).height_ellipsoid_m);
  EXPECT_FALSE(log.events.at(0).yaw_pitch_roll_rad);
  EXPECT_THAT(InWords(log.warnings),
              Contains(AllOf(HasSubstr("Altitude (furlongs)"), HasSubstr("\"furlongs\""))));
  EXPECT_THAT(InWords(log.warnings), Contains(HasSubstr("\"mils\"")));
  EXPECT_THAT(InWords(log.warnings), Contains(HasSubstr("\"phi\", \"kappa\" are not used")));
}

// A track of four rows, a second apart, from 21:31:09 UTC.
void ExpectTrack(const std::string& text, bool is_utc) {
  const FlightLog log = Parse(text);
  ASSERT_EQ(log.gnss.size(), 4u) << text;
  EXPECT_NEAR(log.gnss[3].t_s - log.gnss[0].t_s, 3.0, 1e-6) << text;
  const auto& zero = is_utc ? log.utc_at_zero : log.local_at_zero;
  ASSERT_TRUE(zero) << text;
  const auto first = *zero + std::chrono::microseconds(std::llround(log.gnss[0].t_s * 1e6));
  EXPECT_EQ(first, *UtcFromCivil(2016, 6, 23, 21, 31, 9.0)) << text;
}

std::string Track(const std::string& header, const std::vector<std::string>& times) {
  std::string text = header + "\n";
  for (std::size_t i = 0; i < times.size(); ++i)
    text += times[i] + ",46.84" + std::to_string(260 + i) + ",-91.99,158.5\n";
  return text;
}

std::vector<std::string> Times(const std::string& before, const std::string& after) {
  return {before + "09" + after, before + "10" + after, before + "11" + after, before + "12" + after};
}

TEST(WrittenTables, ReadsClocksInAllTheirColumns) {
  ExpectTrack(Track("Date/Time (UTC),lat,lon,alt", Times("6/23/2016 09:31:", " PM")), true);
  ExpectTrack(Track("Date/Time (UTC+00:00),lat,lon,alt", Times("6/23/2016 09:31:", " PM")), true);
  for (const char* local :
       {"Date/Time (UTC+2)", "Date/Time (GMT -07:00)", "Time [UTC+05:30]", "Time (UTC + 2)",
        "Date/Time (GMT - 07:00)", "UTC time (UTC+2)", "Time UTC (UTC+02:00)"})
    ExpectTrack(Track(std::string(local) + ",lat,lon,alt", Times("6/23/2016 09:31:", " PM")), false);
  ExpectTrack(Track("datetime,lat,lon,alt", Times("23.06.2016 21:31:", "")), false);
  ExpectTrack(Track("date,time,lat,lon,alt", Times("2016-06-23,21:31:", "")), false);
  ExpectTrack(Track("date,time (utc),lat,lon,alt", Times("23/06/2016,9:31:", " PM")), true);
  ExpectTrack(Track("DATE,TIME,lat,lon,alt", Times("20160623,2131", "")), false);
  ExpectTrack(Track("time,lat,lon,alt", Times("2016-06-23T21:31:", "Z")), true);
  ExpectTrack(Track("timestamp,lat,lon,alt", Times("2016-06-23T21:31:", ".000+00:00")), true);
  ExpectTrack(Track("Zeitstempel,Breite,Laenge,Hoehe", Times("23.06.2016 21:31:", "")), false);
  ExpectTrack(Track("timestamp,lat,lon,alt", {"1466717469", "1466717470", "1466717471", "1466717472"}), true);
  ExpectTrack(Track("time,lat,lon,alt", {"1466717469000", "1466717470000", "1466717471000", "1466717472000"}),
              true);
  ExpectTrack(Track("datetime,lat,lon,alt", {"1466717469", "1466717470", "1466717471", "1466717472"}), true);
}

TEST(WrittenTables, TakesTheLeapSecondsOffGpsTime) {
  const auto ahead = [](const std::string& before, const std::string& after) {  // by 17 s in that year
    return std::vector<std::string>{before + "26" + after, before + "27" + after, before + "28" + after,
                                    before + "29" + after};
  };
  ExpectTrack(Track("time,lat,lon,alt", ahead("2016-06-23 21:31:", " GPST")), true);
  ExpectTrack(Track("date,time,lat,lon,alt", ahead("2016-06-23,21:31:", " GPST")), true);
  for (const char* name : {"Time (GPST)", "GPST", "datetime [GPST]", "GPSTimestamp (GPST)"})
    ExpectTrack(Track(std::string(name) + ",lat,lon,alt", ahead("2016-06-23 21:31:", "")), true);
  ExpectTrack(Track("date,time (GPST),lat,lon,alt", ahead("2016-06-23,21:31:", "")), true);
}

TEST(WrittenTables, TellsDayFromMonthByAllRows) {
  std::vector<std::string> late = Times("6/3/2016 23:59:", "");
  late.emplace_back("6/4/2016 00:00:01");
  const FlightLog together = Parse(Track("datetime (utc),lat,lon,alt", late));
  EXPECT_EQ(*together.utc_at_zero, *UtcFromCivil(2016, 6, 3, 23, 59, 9.0));
  EXPECT_THAT(together.mapping, Contains(HasSubstr("month first, which keeps the rows together")));
  const FlightLog open = Parse(Track("datetime (utc),lat,lon,alt", Times("03.06.2016 21:31:", "")));
  EXPECT_EQ(*open.utc_at_zero, *UtcFromCivil(2016, 6, 3, 21, 31, 9.0));
  EXPECT_THAT(InWords(open.warnings), Contains(HasSubstr("are read as day first")));
  const FlightLog shown = Parse(Track("datetime (utc),lat,lon,alt", Times("6/23/2016 21:31:", "")));
  EXPECT_THAT(shown.mapping, Contains(HasSubstr("month first, as \"6/23/2016 21:31:09\" in line 2 says")));
  EXPECT_THAT(Refusal(Track("datetime,lat,lon,alt", Times("31/31/2016 21:31:", ""))),
              AllOf(HasSubstr("has no row with a time"), HasSubstr("\"31/31/2016 21:31:09\"")));
}

TEST(WrittenTables, ReadsFlightRecordsOfDji) {
  std::string text =
      "sep=,\nCUSTOM.date [local],CUSTOM.updateTime [local],OSD.flyTime,OSD.flyTime [s],OSD.latitude,OSD.longitude,"
      "OSD.height [ft],OSD.altitude [ft],OSD.pitch,OSD.roll,OSD.yaw,OSD.yaw [360],GIMBAL.pitch,GIMBAL.roll,"
      "GIMBAL.yaw,CAMERA.isPhoto\n";
  for (int i = 0; i < 60; ++i) {
    text += fmt::format(
        "6/23/2016,4:31:{:02d}.00 PM,0m {}.0s,{}.0,46.84{:03d},-91.99,100.0,620.0,1,2,46,46,-89.9,0,45,{}\n",
        i, i, i, i, i % 10 == 5 ? "True" : "");
  }
  const FlightLog log = Parse(text);
  EXPECT_EQ(log.gnss.size(), 60u);
  EXPECT_NEAR(*log.gnss[0].height_amsl_m, 188.976, 1e-6);
  EXPECT_NEAR(log.baro[0].height_above_takeoff_m, 30.48, 1e-6);
  ASSERT_EQ(log.events.size(), 6u);
  EXPECT_NEAR(log.events[1].t_s, 15.0, 1e-6);
  ASSERT_TRUE(log.local_at_zero);
  EXPECT_NEAR(
      std::chrono::duration<double>(*log.local_at_zero - *UtcFromCivil(2016, 6, 23, 16, 31, 0.0)).count(),
      0.0, 0.1);
}

TEST(WrittenTables, ReadsSecondsSinceTheStart) {
  const FlightLog log = Parse(Track("elapsed,lat,lon,alt", {"0:00:09", "0:00:11", "0:00:13", "0:00:15"}));
  ASSERT_EQ(log.gnss.size(), 4u);
  EXPECT_NEAR(log.gnss[3].t_s, 6.0, 1e-9);
  EXPECT_FALSE(log.utc_at_zero);
}

TEST(WrittenTables, ReadsListsOfExiftoolWithLocalDates) {
  const FlightLog log = Parse(
      "SourceFile,DateTimeOriginal,GPSLatitude,GPSLongitude,GPSAltitude\n"
      "./a.JPG,2016:06:23 16:31:19,\"46 deg 50' 33.39\"\" N\",\"91 deg 59' 40.42\"\" W\",198.3 m Above Sea Level\n"
      "./b.JPG,2016:06:23 16:31:26,\"46 deg 50' 33.69\"\" N\",\"91 deg 59' 39.94\"\" W\",198.6 m Above Sea Level\n");
  ASSERT_EQ(log.events.size(), 2u);
  EXPECT_TRUE(log.gnss.empty()) << "rows of photos are no track";
  EXPECT_FALSE(log.events[0].has_time);
  EXPECT_NEAR(log.events[0].position->lat_deg, 46.842608, 1e-6);
  EXPECT_NEAR(log.events[1].position->lon_deg, -91.994428, 1e-6);
  EXPECT_NEAR(*log.events[1].height_amsl_m, 198.6, 1e-9);
}

TEST(WrittenTables, TakesTheCamerasAnglesBeforeTheAirframes) {
  const FlightLog log = Parse(
      "SourceFile,GPSLatitude,GPSLongitude,Pitch,Yaw,Roll,GimbalRollDegree,GimbalYawDegree,GimbalPitchDegree\n"
      "./a.JPG,46.842608,-91.994561,-12.4,91.0,1.2,+0.00,+90.1,-90.00\n"
      "./b.JPG,46.842692,-91.994428,-11.9,91.0,1.1,+0.00,+90.2,-60.00\n");
  ASSERT_EQ(log.events.size(), 2u);
  EXPECT_EQ(log.events[0].attitude_kind, AttitudeKind::kGimbal);
  EXPECT_NEAR(log.events[1].yaw_pitch_roll_rad->x(), geo::DegToRad(90.2), 1e-9);
  EXPECT_NEAR(log.events[1].yaw_pitch_roll_rad->y(), geo::DegToRad(-60.0), 1e-9);
}

TEST(WrittenTables, TakesNoCountOfSatellitesForAnAccuracy) {
  const FlightLog log = Parse(
      "time_s,lat,lon,alt,SV\n0,46.8426,-91.9945,500,14\n1,46.8427,-91.9945,500,14\n"
      "2,46.8428,-91.9945,500,14\n");
  ASSERT_EQ(log.gnss.size(), 3u);
  EXPECT_FALSE(log.gnss[0].sigma_vertical_m);
}

TEST(WrittenTables, ExplainsWhatStopsATable) {
  const auto why = [](std::string_view text) {
    return InWords(ExplainUnknownTable(BytesOf(text), "a.csv").value_or(""));
  };
  EXPECT_THAT(why("image,lat,Rechtswert\na.jpg,46.8,8.1\nb.jpg,46.8,8.1\n"),
              AllOf(HasSubstr("no column of it is recognised as a longitude"),
                    HasSubstr("Rechtswert (\"8.1\" in line 2)")));
  EXPECT_THAT(why("1;46,8;8,1\n2;46,9;8,2\n"),
              AllOf(HasSubstr("line 1, \"1;46,8;8,1\""), HasSubstr("no names of columns")));
  EXPECT_THAT(why("P1,5188169.6,576691.6,158.5,nail\nP2,5188201.2,576702.9,158.9,nail\n"),
              HasSubstr("imported under Control points"));
  EXPECT_THAT(why("#stamp,lat,lon\n1,46.8,8.1\n2,46.8,8.1\n"), HasSubstr("stamp (\"1\" in line 2)"));
  EXPECT_THAT(why("stamp;lat;lon\n1;N46,8;8,1\n2;N46,9;8,2\n"),
              HasSubstr("not recognised are stamp (\"1\" in line 2)"));
}

}  // namespace
}  // namespace skyquilt::flight
