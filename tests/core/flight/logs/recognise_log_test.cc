// What lies beside logs and is none, by its first bytes.
#include <gtest/gtest.h>

#include <string>

#include "core/flight/logs/read_log.h"

namespace skyquilt::flight {
namespace {

std::string WhyNot(const std::string& bytes, const std::string& name) {
  const auto format = RecogniseLog(BytesOf(bytes), name);
  return format.ok() ? std::string("nothing") : format.error().message;
}

TEST(RecogniseLog, SaysWhatAPlanATrackOfAWatchAndRawObservationsAre) {
  const auto why = WhyNot;
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

TEST(RecogniseLog, SaysWhatADocumentOfAnOfficeProgramIs) {
  const std::string zip = "PK\3\4" + std::string(26, '\0');
  for (const char* first : {"[Content_Types].xml", "docProps/app.xml", "_rels/.rels", "xl/workbook.xml",
                            "mimetypeapplication/vnd.oasis.opendocument.spreadsheetPK"})
    EXPECT_NE(WhyNot(zip + first, "positions").find("as CSV"), std::string::npos) << first;
  EXPECT_NE(WhyNot(zip + "Index/Document.iwa", "positions.numbers").find("as CSV"), std::string::npos);
  const std::string compound = "\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1" + std::string(64, '\0');
  EXPECT_NE(WhyNot(compound, "Positions.XLS").find("as CSV"), std::string::npos);
  EXPECT_EQ(WhyNot(compound, "Thumbs.db"), "nothing");
  EXPECT_EQ(WhyNot(zip + "DCIM/DJI_0001.JPG", "photos.zip"), "nothing");
  EXPECT_EQ(WhyNot("PK\3\4", "a.zip"), "nothing") << "cut off";
}

}  // namespace
}  // namespace skyquilt::flight
