#include <gtest/gtest.h>

#include "core/video/take_frames.h"

namespace skyquilt::video {
namespace {

flight::GnssSample Fix(double t_s, double lat_deg) {
  flight::GnssSample fix;
  fix.t_s = t_s;
  fix.position = {lat_deg, 8.0};
  fix.height_amsl_m = 100.0 + t_s;
  return fix;
}

TEST(FrameTable, IsBetweenTheSamplesByStraightLines) {
  flight::FlightLog log;
  log.gnss = {Fix(0.0, 50.0), Fix(2.0, 50.0002)};
  log.baro = {{0.0, 30.0}, {2.0, 31.0}};
  const std::string table = FrameTable({"a.jpg", "b \"1\".jpg"}, {0.5, 2.5}, log);
  EXPECT_NE(table.find("\"a.jpg\",50.000050000,8.000000000,100.500,,,30.250,,,\n"), std::string::npos)
      << table;
  EXPECT_NE(table.find("\"b \"\"1\"\".jpg\",50.000200000,8.000000000,102.000,,,31.000,,,\n"),
            std::string::npos)
      << table;
}

TEST(FrameTable, SaysNothingOfTimesThatTheLogDoesNotCover) {
  flight::FlightLog log;
  log.gnss = {Fix(0.0, 50.0), Fix(100.0, 50.1)};
  EXPECT_EQ(FrameTable({"a.jpg"}, {50.0}, log), "") << "too long a gap";
  EXPECT_EQ(FrameTable({"a.jpg"}, {200.0}, log), "");
  EXPECT_EQ(FrameTable({"a.jpg"}, {0.0}, {}), "");
  EXPECT_EQ(FrameTable({}, {}, log), "");
}

}  // namespace
}  // namespace skyquilt::video
