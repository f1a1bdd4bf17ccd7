// reflectance.csv: rows of panels in photos and of targets on the ground, and rows that cannot be used.
#include "core/flight/lists/reflectance_list.h"

#include <gmock/gmock.h>

#include "core/flight/read_flight.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(ReflectanceList, ReadsPanelsAndTargets) {
  const auto list = test::ValueOf(
      ParseReflectanceList("reflectance.csv",
                           "Photo,left,top,right,bottom,lat,lon,radius_m,Reflectance,Red edge,nir\n"
                           "IMG_0001_1.tif,10,20,110,90,,,,0.52,,\n"
                           "# a comment\n"
                           "IMG_0002_4.tif,,,,,,,,,51.5%,0.49\n"
                           "\n"
                           ",,,,,46.5,7.25,2.5,0.11,,0.2\n"));
  EXPECT_TRUE(list.warnings.empty());
  ASSERT_THAT(list.panels, SizeIs(2));
  EXPECT_THAT(*list.panels[0].box_px, ElementsAre(10, 20, 110, 90));
  EXPECT_EQ(list.panels[0].reflectance.all, 0.52);
  EXPECT_FALSE(list.panels[1].box_px);
  EXPECT_DOUBLE_EQ(list.panels[1].reflectance.bands.at("red edge"), 0.515);
  EXPECT_EQ(list.panels[1].reflectance.bands.at("nir"), 0.49);
  ASSERT_THAT(list.targets, SizeIs(1));
  EXPECT_EQ(list.targets[0].center.lat_deg, 46.5);
  EXPECT_EQ(list.targets[0].radius_m, 2.5);
  EXPECT_EQ(list.targets[0].reflectance.all, 0.11);
  EXPECT_EQ(list.targets[0].reflectance.bands.at("nir"), 0.2);
  const std::vector<ReflectanceList> lists = {list};
  EXPECT_EQ(FindPanelRow(lists, "img_0002_4.TIF"), &lists[0].panels[1]) << "whatever the case";
  EXPECT_EQ(FindPanelRow(lists, "IMG_0003_4.tif"), nullptr);
  EXPECT_EQ(FindPanelRow(lists, "2_4.tif"), nullptr) << "a part of a name";
}

TEST(ReflectanceList, OtherSeparatorsAndLineEndsAreRead) {
  const auto list = ParseReflectanceList("r.csv", "\xEF\xBB\xBFlat;lon;radius_m;green\r\n1;2;3;0.5\r\n");
  ASSERT_TRUE(list.ok());
  EXPECT_EQ(list->targets[0].reflectance.bands.at("green"), 0.5);
}

TEST(ReflectanceList, SaysWhatIsWrongWithARow) {
  const auto list =
      test::ValueOf(ParseReflectanceList("r.csv",
                                         "photo,left,top,right,bottom,lat,lon,radius_m,reflectance\n"
                                         "a.tif,,,,,,,,0.5\n"
                                         "b.tif,,,,,,,,7\n"
                                         "b.tif,1,2,,,,,,0.5\n"
                                         "b.tif,9,2,3,4,,,,0.5\n"
                                         "b.tif,x,2,3,4,,,,0.5\n"
                                         ",,,,,95,7,2,0.5\n"
                                         ",,,,,45,7,-2,0.5\n"
                                         ",,,,,45,7,2,\n"
                                         ",,,,,,,,0.5\n"
                                         "b.tif\n"));
  EXPECT_THAT(list.panels, SizeIs(2)) << "the last has a photo alone: its panel's code is looked for";
  EXPECT_THAT(list.targets, SizeIs(0));
  EXPECT_THAT(InWords(list.warnings),
              ElementsAre(HasSubstr("line 3: \"7\" is no reflectance"), HasSubstr("belong together"),
                          HasSubstr("right is not beyond left"), HasSubstr("\"x\" is no number"),
                          HasSubstr("not on Earth"), HasSubstr("radius"), HasSubstr("names no reflectance"),
                          HasSubstr("neither a photo nor")));
}

TEST(ReflectanceList, OfNothingIsRefusedInWords) {
  EXPECT_EQ(ParseReflectanceList("r.csv", "").error().code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(ParseReflectanceList("r.csv", "a,b\n1,2\n").error().message,
              HasSubstr("lat, lon and radius_m"));
  EXPECT_EQ(ParseReflectanceList("r.csv", "photo\n").error().code, ErrorCode::kCorrupt);
  const auto unread = ParseReflectanceList("r.csv", "lat,lon,radius_m\nx,y,z\n");
  EXPECT_THAT(unread.error().message, HasSubstr("(line 2: \"x\" is no number)"));
  EXPECT_EQ(WhyOf(unread.error()).code, RemarkCode::kReflectancesUnusedAs);
  EXPECT_FALSE(ParseReflectanceList("r.csv", std::string(2000, '\0')).ok());
  std::string long_list = "photo\n";
  for (int i = 0; i < 10'001; ++i) long_list += std::to_string(i) + ".tif\n";
  const auto cut = test::ValueOf(ParseReflectanceList("r.csv", long_list));
  EXPECT_THAT(cut.panels, SizeIs(10'000));
  EXPECT_THAT(InWords(cut.warnings), ElementsAre(HasSubstr("first 10000 rows")));
}

TEST(ReflectanceList, HoldsABoundedNumberOfTargets) {
  std::string many = "lat,lon,radius_m,reflectance\n";
  for (int i = 0; i < 101; ++i) many += "46.5,7.25,1,0.5\n";
  const auto list = test::ValueOf(ParseReflectanceList("r.csv", many));
  EXPECT_THAT(list.targets, SizeIs(100));
  EXPECT_THAT(InWords(list.warnings), ElementsAre(HasSubstr("line 102: only the first 100")));
}

TEST(ReflectanceList, IsKnownByItsName) {
  EXPECT_TRUE(IsReflectanceList("Reflectance.CSV"));
  EXPECT_TRUE(IsReflectanceList("flight/reflectance.csv"));
  EXPECT_FALSE(IsReflectanceList("my_reflectance.csv"));
}

TEST(ReflectanceList, ThatCannotBeReadIsToldAndHarmsNothing) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  const auto flight = ReadFlight({{"reflectance.csv", folder.Write("reflectance.csv", "a,b\n")},
                                  {"x.jpg", folder.Write("x.jpg", "no photo")}},
                                 1, progress);
  ASSERT_TRUE(flight.ok());
  EXPECT_TRUE(flight->reflectance_lists.empty());
  EXPECT_THAT(InWords(flight->warnings),
              ::testing::Contains(HasSubstr("has no columns by which its rows are found")));
}

}  // namespace
}  // namespace skyquilt::flight
