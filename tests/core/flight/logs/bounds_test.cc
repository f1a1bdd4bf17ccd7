// What the parsers of logs take of files that were made to cost: counted, not timed.
#include <gmock/gmock.h>

#include "core/flight/logs/autopilots/ulog_types.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/logs/log_writers.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using test::ValueOf;
using testing::Bytes;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::TlogWriter;
using testing::UlogWriter;

// Types of `wide` members of the type before, `deep` deep: wide to the power of deep members if each is
// walked again.
UlogTypes Nested(int deep, int wide) {
  UlogTypes types;
  EXPECT_TRUE(types.Define("t0:uint8_t[0] a;"));
  for (int level = 1; level <= deep; ++level) {
    std::string definition = "t" + std::to_string(level) + ":";
    for (int i = 0; i < wide; ++i)
      definition += "t" + std::to_string(level - 1) + " m" + std::to_string(i) + ";";
    EXPECT_TRUE(types.Define(definition + "uint64_t timestamp;"));
  }
  return types;
}

TEST(UlogTypes, EachMemberIsLookedAtOnce) {
  UlogTypes types = Nested(7, 100);
  for (int question = 0; question < 1000; ++question) {
    types.Find("t7", "timestamp");
    types.SizeOf("t7");
  }
  EXPECT_LE(types.steps(), 7 * 101 + 1);
  UlogTypes sized = Nested(3, 10);
  EXPECT_EQ(sized.SizeOf("t3"), 8U * 111U);
  EXPECT_EQ(ValueOf(sized.Find("t3", "timestamp")).offset, 8U * 110U);
}

TEST(UlogTypes, QuestionsBetweenDefinitionsEnd) {
  UlogTypes types = Nested(7, 1000 - 1);
  for (int i = 0; i < 1900; ++i) {
    types.Define("more" + std::to_string(i) + ":uint8_t a;");
    types.Find("t7", "timestamp");
  }
  EXPECT_LE(types.steps(), 1'000'001);
}

TEST(UlogTypes, TakesOnlySoManyDefinitionsAndMembers) {
  UlogTypes types;
  int taken = 0;
  for (int i = 0; i < 5000; ++i) taken += types.Define("same:uint8_t a;") ? 1 : 0;
  EXPECT_EQ(taken, 2000);
  UlogTypes wide;
  std::string members;
  for (int i = 0; i < 900; ++i) members += "uint8_t m;";
  taken = 0;
  for (int i = 0; i < 100; ++i) taken += wide.Define("t" + std::to_string(i) + ":" + members) ? 1 : 0;
  EXPECT_EQ(taken, 55);
}

TEST(UlogTypes, ALaterDefinitionCounts) {
  UlogTypes types;
  ASSERT_TRUE(types.Define("outer:inner a;uint64_t timestamp;"));
  EXPECT_FALSE(types.SizeOf("outer"));
  ASSERT_TRUE(types.Define("inner:uint16_t b;"));
  EXPECT_EQ(types.SizeOf("outer"), 10U);
  EXPECT_EQ(types.Find("outer", "timestamp")->offset, 2U);
  ASSERT_TRUE(types.Define("loop:loop a;uint64_t timestamp;"));
  EXPECT_FALSE(types.SizeOf("loop"));
  EXPECT_FALSE(types.Find("loop", "timestamp"));
}

TEST(ParseUlog, TakesOnlySoManySubscriptions) {
  UlogWriter writer;
  writer.Define("vehicle_air_data:uint64_t timestamp;float baro_alt_meter;");
  for (int i = 0; i < 20'000; ++i) writer.Subscribe(static_cast<std::uint16_t>(i % 7), "vehicle_air_data");
  Bytes payload;
  testing::Append(payload, std::uint64_t{1'000'000});
  testing::Append(payload, 12.5F);
  writer.Data(0, payload);
  const auto log = ValueOf(ParseUlog("a.ulg", writer.bytes(), {}));
  EXPECT_EQ(log.baro.size(), 1U);
  EXPECT_THAT(InWords(log.warnings), Contains(HasSubstr("more than 10000 subscriptions")));
}

TEST(ParseMavlinkTlog, CountsOnlySoManyKinds) {
  TlogWriter writer;
  for (std::uint32_t kind = 0; kind < 5000; ++kind)
    writer.Packet(1'700'000'000'000'000 + kind, 100'000 + kind, 0, Bytes(9, 0), true);
  const auto log = ValueOf(ParseMavlinkTlog("a.tlog", writer.bytes(), {}));
  EXPECT_LE(log.message_counts.size(), 1001U);
  std::uint64_t total = 0;
  for (const auto& [kind, count] : log.message_counts) total += count;
  EXPECT_EQ(total, 5000U);
}

TEST(ParseGcpList, TakesOnlySoManySightings) {
  std::string text = "EPSG:4326\n";
  for (int i = 0; i < 100'100; ++i) text += "8.5 47.4 400 " + std::to_string(i) + " 5 a.jpg\n";
  const auto list = ValueOf(ParseGcpList("gcp_list.txt", BytesOf(text)));
  EXPECT_EQ(list.sightings.size(), 100'000U);
  EXPECT_THAT(InWords(list.warnings), Contains(HasSubstr("more than 100000 sightings")));
}

TEST(ParseGeoTxt, TakesOnlySoManyRows) {
  std::string text = "EPSG:4326\n";
  for (int i = 0; i < 250'000; ++i) text += "a.jpg 8 47\n";
  const auto log = ValueOf(ParseGeoTxt("geo.txt", BytesOf(text), {}));
  EXPECT_EQ(log.events.size(), 200'000U);
  EXPECT_THAT(InWords(log.warnings), Contains(HasSubstr("more than 200000 rows")));
}

TEST(ParseGpx, AttributesAreReadOnceAndTagsAreShort) {
  const auto parse = [](const std::string& tag) {
    return ParseGpx("a.gpx",
                    BytesOf("<gpx><trk><trkseg><trkpt " + tag +
                            "><ele>5</ele><time>2024-05-01T10:00:00Z</time></trkpt></trkseg></trk></gpx>"),
                    {});
  };
  for (const char* tag : {"lat=\"47.4\" lon=\"8.5\"", "lon = '8.5'\n lat\t=\n\"47.4\"",
                          "xlat=\"1\" note=\"lat='2'\" lat=\"47.4\" lon=\"8.5\""}) {
    const auto log = ValueOf(parse(tag));
    ASSERT_EQ(log.gnss.size(), 1U) << tag;
    EXPECT_DOUBLE_EQ(log.gnss[0].position.lat_deg, 47.4) << tag;
    EXPECT_DOUBLE_EQ(log.gnss[0].position.lon_deg, 8.5) << tag;
  }
  std::string repeated;
  for (int i = 0; i < 10'000; ++i) repeated += "lat ";
  EXPECT_FALSE(parse(repeated + std::string(30'000, ' ') + "lat=\"47.4\" lon=\"8.5\"").ok());
}

}  // namespace
}  // namespace skyquilt::flight
