#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/explain_unknown.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::flight {
namespace {

// Letters of the first plane only.
std::string Utf16(std::u16string_view text, bool is_big_endian, bool has_mark) {
  std::string bytes;
  const auto put = [&](char16_t unit) {
    const char low = static_cast<char>(unit & 0xFF), high = static_cast<char>(unit >> 8);
    bytes += is_big_endian ? high : low;
    bytes += is_big_endian ? low : high;
  };
  if (has_mark) put(0xFEFF);
  for (const char16_t unit : text) put(unit);
  return bytes;
}

TEST(LogText, DecodesBothOrdersWithAndWithoutMark) {
  for (const bool is_big_endian : {false, true}) {
    for (const bool has_mark : {false, true}) {
      const std::string bytes = Utf16(u"image;latitude;longitude\r\n", is_big_endian, has_mark);
      const auto text = LogText::Of("a.csv", BytesOf(bytes));
      ASSERT_TRUE(text.ok());
      EXPECT_TRUE(text->is_decoded());
      EXPECT_EQ(TextOf(text->bytes()), "image;latitude;longitude\r\n");
    }
  }
  const std::string signs = Utf16(u"46\u00B050\u2032 \U0001F681 \xD800 end", false, true);
  EXPECT_EQ(TextOf(LogText::Of("a", BytesOf(signs))->bytes()),
            "46\xC2\xB0"
            "50\xE2\x80\xB2 \xF0\x9F\x9A\x81 \xEF\xBF\xBD end");
}

TEST(LogText, LeavesOtherBytesAsTheyAre) {
  for (const std::string& bytes :
       {std::string("image,lat\n"), std::string("\xFF\xFE\0\0a\0\0\0", 8),
        std::string("\xFF\xD8\xFF\xE0 jpeg"), std::string("a\0b\0", 4), std::string()}) {
    const auto text = LogText::Of("a", BytesOf(bytes));
    ASSERT_TRUE(text.ok());
    EXPECT_FALSE(text->is_decoded());
    EXPECT_EQ(TextOf(text->bytes()), bytes);
  }
  const std::string marked = "\xEF\xBB\xBFimage";
  EXPECT_EQ(TextOf(LogText::Of("a", BytesOf(marked))->bytes()), "image");
}

TEST(LogText, RefusesWhatWouldNotFit) {
  std::string bytes((std::size_t{64} << 20) + 2, '\0');
  bytes[0] = '\xFF';
  bytes[1] = '\xFE';
  bytes[2] = 'a';
  const auto text = LogText::Of("big.csv", BytesOf(bytes));
  ASSERT_FALSE(text.ok());
  EXPECT_NE(text.error().message.find("big.csv"), std::string::npos);
  EXPECT_NE(text.error().message.find("save it as UTF-8"), std::string::npos);
}

TEST(ReadLog, ReadsAnySortOfTextInUtf16) {
  const auto table =
      Utf16(u"time_s\tlat\tlon\talt_m\n1\t46.8\t7.1\t500\n2\t46.8001\t7.1\t500\n", false, true);
  EXPECT_EQ(**RecogniseLog(BytesOf(table), "a.csv"), LogFormat::kTolerantCsv);
  EXPECT_EQ(ParseLog("a.csv", BytesOf(table))->gnss.size(), 2u);
  const auto gpx = Utf16(
      u"<?xml version=\"1.0\"?><gpx><trk><trkseg><trkpt lat=\"46.8\" lon=\"7.1\"><ele>1</ele>"
      u"<time>2016-06-23T21:31:09Z</time></trkpt></trkseg></trk></gpx>",
      true, true);
  EXPECT_EQ(ParseLog("a.gpx", BytesOf(gpx))->gnss.size(), 1u);
  const auto unknown = Utf16(u"stamp,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n", false, true);
  EXPECT_TRUE(ExplainUnknownTable(LogText::Of("a.csv", BytesOf(unknown))->bytes(), "a.csv"));
  const auto subtitles = Utf16(u"1\n00:00:01,000 --> 00:00:02,000\nGPS(7.1,46.8,15)\n\n", false, true);
  EXPECT_EQ(ParseFilmSubtitles("a.srt", BytesOf(subtitles))->gnss.size(), 1u);
}

TEST(ReadGcpList, ReadsUtf16) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "gcp_list.txt";
  std::ofstream(path, std::ios::binary)
      << Utf16(u"EPSG:32615\n576667.1 5188164.6 198.3 100 200 a.jpg gcp1\n", false, true);
  for (const auto& list : {ReadGcpList({"gcp_list.txt", path}), ReadWrittenGcpList({"gcp_list.txt", path})}) {
    ASSERT_TRUE(list.ok()) << list.error().message;
    EXPECT_EQ(list->sightings.size(), 1u);
  }
}

}  // namespace
}  // namespace skyquilt::flight
