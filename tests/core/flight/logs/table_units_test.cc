// What columns without a unit are by their numbers, and what their numbers cannot be.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/read_log.h"
#include "core/geo/lat_lon.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using geo::DegToRad;
using ::testing::HasSubstr;

FlightLog LogOfTable(std::string_view text) {
  return test::ValueOf(ParseTolerantCsv("table.csv", BytesOf(text)));
}

std::string WhyNoTable(std::string_view text) {
  return test::ErrorOf(ParseTolerantCsv("table.csv", BytesOf(text))).message;
}

constexpr int kRows = 40;
constexpr double kStepDeg = 8.0 / 111'320.0;  // 8 m northwards

// Out to the north and back, eight metres from row to row.
double LatDeg(int row) { return 47.0 + kStepDeg * (row < kRows / 2 ? row : kRows - row); }
double CourseDeg(int row) { return row <= kRows / 2 ? 0.0 : 180.0; }

// Rows of time, place and what `more` adds.
template <typename More>
std::string Table(std::string_view header, double time_step, const More& more) {
  std::string text(header);
  for (int row = 0; row < kRows; ++row)
    text += fmt::format("\n{},{:.8f},8.1,{}", 100.0 + time_step * row, LatDeg(row), more(row));
  return text + "\n";
}

TEST(TableUnits, RefusesSwappedCoordinates) {
  EXPECT_THAT(
      WhyNoTable("time_s,lat,lon,alt\n0,113.9123,22.5411,90\n1,113.9124,22.5411,90\n2,113.9125,22.5411,90\n"),
      HasSubstr("113.912 is no latitude"));
}

TEST(TableUnits, RefusesDegreesWithMinutesAndMetresOfAPlane) {
  EXPECT_THAT(WhyNoTable("time_s,lat,lon\n0,4650.5565,09159.6707\n1,4650.5566,09159.6708\n"),
              HasSubstr("no latitude"));
  EXPECT_THAT(WhyNoTable("time_s,Latitude,Longitude\n0,5190123.4,650321.7\n1,5190124.4,650321.8\n"),
              HasSubstr("no latitude"));
  EXPECT_THAT(WhyNoTable("time_s,Latitude,Longitude\n0,5190123,650321\n1,5190124,650322\n"),
              HasSubstr("no latitude"))
      << "whole metres";
}

TEST(TableUnits, ReadsWholeNumbersAsSmallDegreesAndMillimetres) {
  const FlightLog log = LogOfTable(
      "timestamp,lat,lon,alt\n1000000,470123456,81234567,512345\n1200000,470123466,81234567,515345\n"
      "1400000,470123476,81234567,518345\n");
  ASSERT_EQ(log.gnss.size(), 3u);
  EXPECT_NEAR(log.gnss[0].position.lat_deg, 47.0123456, 1e-9);
  EXPECT_NEAR(log.gnss[0].position.lon_deg, 8.1234567, 1e-9);
  EXPECT_NEAR(*log.gnss[2].height_amsl_m, 518.345, 1e-6);
}

TEST(TableUnits, ReadsSmallDegreesBetweenWholeNumbers) {
  const FlightLog log = LogOfTable(
      "timestamp,lat,lon,alt\n1000000,470123456,81234567,512.1\n1200000,470123461.5,81234567.25,512.3\n"
      "1400000,470123466,81234568,512.4\n");
  ASSERT_EQ(log.gnss.size(), 3u);
  EXPECT_NEAR(log.gnss[1].position.lat_deg, 47.01234615, 1e-9);
}

TEST(TableUnits, LeavesWholeMetresBesideSmallDegrees) {
  const FlightLog log = LogOfTable(
      "timestamp,lat,lon,alt\n1000000,470123456,81234567,512\n1200000,470123466,81234567,513\n"
      "1400000,470123476,81234567,530\n");
  ASSERT_EQ(log.gnss.size(), 3u);
  EXPECT_NEAR(*log.gnss[2].height_amsl_m, 530.0, 1e-6);
}

TEST(TableUnits, FindsRadiansByTheCourse) {
  const auto angles = [](double unit) {
    return [unit](int row) {
      return fmt::format("60,{:.4f},{:.4f},{:.4f}", 3 * unit, -2 * unit, CourseDeg(row) * unit);
    };
  };
  constexpr std::string_view kHeader = "time_s,lat,lon,alt,roll,pitch,yaw";
  for (const double unit : {1.0, DegToRad(1.0)}) {
    const FlightLog log = LogOfTable(Table(kHeader, 1.0, angles(unit)));
    ASSERT_EQ(log.attitude.size(), static_cast<std::size_t>(kRows));
    for (const int row : {5, 30}) {
      const Eigen::Quaterniond expected =
          NedFromYawPitchRoll(DegToRad(CourseDeg(row)), DegToRad(-2.0), DegToRad(3.0));
      EXPECT_LT(log.attitude[static_cast<std::size_t>(row)].ned_from_body.angularDistance(expected), 1e-3)
          << unit << " " << row;
    }
  }
}

TEST(TableUnits, LeavesDegreesThatPointNorthAllTheWay) {
  const FlightLog log = LogOfTable(Table("time_s,lat,lon,alt,roll,pitch,yaw", 1.0, [](int row) {
    return fmt::format("60,{},0.5,{}", 0.1 * (row % 3), row % 4 - 2);
  }));
  ASSERT_EQ(log.attitude.size(), static_cast<std::size_t>(kRows));
  EXPECT_LT(log.attitude[7].ned_from_body.angularDistance(
                NedFromYawPitchRoll(DegToRad(1.0), DegToRad(0.5), DegToRad(0.1))),
            1e-6);
}

TEST(TableUnits, FindsRadiansInListsOfPhotosToo) {
  std::string text = "file,lat,lon,alt,gimbal_roll,gimbal_pitch,gimbal_yaw";
  for (int row = 0; row < kRows; ++row)
    text += fmt::format("\nDJI_{:04}.JPG,{:.8f},8.1,560,0,-1.5708,{:.4f}", row, LatDeg(row),
                        DegToRad(CourseDeg(row)));
  const FlightLog log = LogOfTable(text + "\n");
  ASSERT_EQ(log.events.size(), static_cast<std::size_t>(kRows));
  EXPECT_NEAR(log.events[30].yaw_pitch_roll_rad->x(), DegToRad(180.0), 1e-3);
  EXPECT_NEAR(log.events[30].yaw_pitch_roll_rad->y(), DegToRad(-90.0), 1e-3);
}

// The other way round than yaw, in degrees of the Earth and in metres of a plane.
TEST(TableUnits, FindsRadiansOfOmegaPhiKappa) {
  for (const bool is_plane : {false, true}) {
    std::string text = is_plane ? "file,northing,easting,height,omega,phi,kappa"
                                : "file,latitude,longitude,altitude,omega,phi,kappa";
    for (int row = 0; row < kRows; ++row)
      text += fmt::format("\nDJI_{:04}.JPG,{:.8f},{},560,0.01,-0.02,{:.4f}", row,
                          is_plane ? 111'320.0 * LatDeg(row) : LatDeg(row), is_plane ? 450'000.0 : 8.1,
                          -DegToRad(CourseDeg(row)));
    const FlightLog log = LogOfTable(text + "\n");
    ASSERT_EQ(log.events.size(), static_cast<std::size_t>(kRows));
    EXPECT_NEAR(std::abs(log.events[30].yaw_pitch_roll_rad->x()), DegToRad(180.0), 1e-3) << is_plane;
    EXPECT_NEAR(log.events[10].yaw_pitch_roll_rad->x(), 0.0, 1e-3) << is_plane;
  }
}

TEST(TableUnits, ANoseThatIsHeldOneWayProvesNothing) {
  std::string text = "time_s,lat,lon,alt,heading";
  for (int row = 0; row < kRows; ++row)  // east all the way
    text += fmt::format("\n{},47.0,{:.8f},60,1.6", row, 8.0 + kStepDeg * row);
  EXPECT_THAT(LogOfTable(text + "\n").mapping, ::testing::Not(::testing::Contains(HasSubstr("rad"))));
}

TEST(TableUnits, LevelIsJudgedOfAnglesAsTheyAre) {
  std::string text = "file,lat,lon,alt,yaw,pitch,roll";
  for (int row = 0; row < kRows; ++row)
    text += fmt::format("\nDJI_{:04}.JPG,{:.8f},8.1,560,{:.4f},-1.5708,0", row, LatDeg(row),
                        DegToRad(CourseDeg(row)));
  const FlightLog log = LogOfTable(text + "\n");
  ASSERT_EQ(log.events.size(), static_cast<std::size_t>(kRows));
  EXPECT_EQ(log.events[30].attitude_kind, AttitudeKind::kGimbal) << "straight down from the horizon";
}

TEST(TableUnits, FindsSecondsFarApartByTheWayFlown) {
  for (const double step : {3.0, 3000.0}) {
    const FlightLog log = LogOfTable(
        Table("time,lat,lon,alt,photo", step, [](int row) { return fmt::format("60,{}.jpg", row); }));
    ASSERT_EQ(log.gnss.size(), static_cast<std::size_t>(kRows));
    EXPECT_NEAR(log.gnss[10].t_s - log.gnss[0].t_s, 30.0, 1e-6) << step;
  }
}

TEST(TableUnits, FindsTheUnitOfPressure) {
  for (const auto& [ground, up] : {std::pair{101325.0, 100604.0}, {1013.25, 1006.04}, {101.325, 100.604}}) {
    const FlightLog log =
        LogOfTable(Table("time_s,lat,lon,alt,pressure", 1.0, [&, ground = ground, up = up](int row) {
          return fmt::format("60,{}", row < 5 ? ground : up);
        }));
    ASSERT_EQ(log.baro.size(), static_cast<std::size_t>(kRows));
    EXPECT_NEAR(log.baro[20].height_above_takeoff_m - log.baro[0].height_above_takeoff_m, 60.2, 1.0)
        << ground;
  }
}

TEST(TableUnits, HeightsUnderTheNameOfABarometerAreNoPressure) {
  const FlightLog log = LogOfTable(
      Table("time_s,lat,lon,alt,pressure", 1.0, [](int row) { return fmt::format("60,{}", 40 + 2 * row); }));
  EXPECT_TRUE(log.baro.empty());
}

TEST(TableUnits, RowsBeforeTheFirstFixSayNothingOfTheClock) {
  std::string text = "time,lat,lon,alt,roll,pitch,yaw";
  for (int row = 0; row < kRows; ++row)
    text += fmt::format("\n{},{},{},60,0,0,0", 5 * row, row < 10 ? 0.0 : 47.0, row < 10 ? 0.0 : 8.1);
  const FlightLog log = LogOfTable(text + "\n");
  ASSERT_FALSE(log.attitude.empty());
  EXPECT_NEAR(log.attitude.back().t_s - log.attitude.front().t_s, 0.195, 1e-6) << "milliseconds";
}

TEST(TableUnits, ListsOfSurveysCountHeightsFromTheEllipsoid) {
  const FlightLog survey =
      LogOfTable("filename,lat,lon,height\na.jpg,47.1,8.1,512.3\nb.jpg,47.1002,8.1,512.9\n");
  EXPECT_EQ(survey.events.at(0).height_ellipsoid_m, 512.3);
  EXPECT_FALSE(survey.events.at(0).height_above_takeoff_m);
  const FlightLog drone =
      LogOfTable("filename,lat,lon,height\na.jpg,47.1,8.1,60.3\nb.jpg,47.1002,8.1,60.9\n");
  EXPECT_EQ(drone.events.at(0).height_above_takeoff_m, 60.3);
  const FlightLog both =
      LogOfTable("filename,lat,lon,altitude,height\na.jpg,47.1,8.1,800,200\nb.jpg,47.1002,8.1,801,201\n");
  EXPECT_EQ(both.events.at(0).height_above_takeoff_m, 200.0) << "no ellipsoid lies 600 m from the sea";
  const FlightLog said =
      LogOfTable("filename,lat,lon,height above takeoff\na.jpg,47.1,8.1,212.3\nb.jpg,47.1002,8.1,212.9\n");
  EXPECT_EQ(said.events.at(0).height_above_takeoff_m, 212.3);
}

TEST(TableUnits, ListsThatSayWhatTheirHeightsAreAreNoneOfPix4ds) {
  const auto heights =
      test::ValueOf(ParseLog("list.csv", BytesOf("image,latitude,longitude,height_above_takeoff\n"
                                                 "a.jpg,47.1,8.1,60\nb.jpg,47.1002,8.1,61\n")));
  EXPECT_EQ(heights.events.at(0).height_above_takeoff_m, 60.0);
  const auto above_sea =
      test::ValueOf(ParseLog("list.csv", BytesOf("image,latitude,longitude,altitude AMSL (m)\n"
                                                 "a.jpg,47.1,8.1,560\nb.jpg,47.1002,8.1,561\n")));
  EXPECT_EQ(above_sea.events.at(0).height_amsl_m, 560.0);
}

}  // namespace
}  // namespace skyquilt::flight
