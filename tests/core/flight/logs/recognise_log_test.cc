// What lies beside logs and is none, by its first bytes.
#include <gtest/gtest.h>

#include <string>

#include "core/flight/logs/read_log.h"

namespace skyquilt::flight {
namespace {

TEST(RecogniseLog, SaysWhatAPlanATrackOfAWatchAndRawObservationsAre) {
  const auto why = [](const std::string& bytes, const std::string& name) {
    const auto format = RecogniseLog(BytesOf(bytes), name);
    return format.ok() ? std::string("nothing") : format.error().message;
  };
  EXPECT_NE(
      why("QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t46.8\t7.1\t450\t1\n", "m.waypoints").find("planned route"),
      std::string::npos);
  EXPECT_NE(why("{\n \"fileType\": \"Plan\", \"mission\": {}}", "m.plan").find("planned route"),
            std::string::npos);
  EXPECT_NE(why(std::string("\x0E\x10\x5D\x08\x40\0\0\0.FIT\0\0", 14), "a.fit").find("GPX"),
            std::string::npos);
  const std::string frame("\xD3\x00\x02\x12\x34\x01\x02\x03", 8);
  EXPECT_NE(why(frame + frame, "rover.rtcm3").find("Timestamp.MRK"), std::string::npos);
  EXPECT_NE(why(frame + "\x01", "100_0001_PPKRAW.bin").find("Timestamp.MRK"), std::string::npos);
  EXPECT_EQ(why(frame + "\x01", "a.bin"), "nothing") << "one frame may be chance";
}

}  // namespace
}  // namespace skyquilt::flight
