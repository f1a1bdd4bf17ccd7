// Times in file names: the patterns of makers and phones, what is no time, and that a flight's names are
// believed together or not at all.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/metadata/capture_time.h"

namespace skyquilt::flight {
namespace {

struct NamedTime {
  const char* name;
  UtcTime time;
  bool is_local;
};

UtcTime At(int year, int month, int day, int hour, int minute, double second) {
  return *UtcFromCivil(year, month, day, hour, minute, second);
}

TEST(TimeInName, ReadsThePatternsOfMakersAndPhones) {
  const NamedTime cases[] = {{"DJI_20230918115823_0001.JPG", At(2023, 9, 18, 11, 58, 23), true},
                             {"DJI_20230918115823_0001_V.JPG", At(2023, 9, 18, 11, 58, 23), true},
                             {"IMG_20190102_030405.jpg", At(2019, 1, 2, 3, 4, 5), true},
                             {"IMG_20190102_030405_1.jpg", At(2019, 1, 2, 3, 4, 5), true},
                             {"100MEDIA/IMG_20190102_030405123.jpg", At(2019, 1, 2, 3, 4, 5.123), true},
                             {"PXL_20210506_070809123.jpg", At(2021, 5, 6, 7, 8, 9.123), false},
                             {"2018080501004480Z.jpg", At(2018, 8, 5, 1, 0, 44.80), false},
                             {"2018-08-05T01-00-44.250Z.png", At(2018, 8, 5, 1, 0, 44.25), false},
                             {"2018-08-05 01.00.44.jpg", At(2018, 8, 5, 1, 0, 44), true},
                             {"survey_20180805T010044Z_b.tif", At(2018, 8, 5, 1, 0, 44), false},
                             {"20180805_010044.jpg (2)", At(2018, 8, 5, 1, 0, 44), true},
                             {"1533430844.jpg", At(2018, 8, 5, 1, 0, 44), false},
                             {"frame_1533430844.25.png", At(2018, 8, 5, 1, 0, 44.25), false},
                             {"1533430844250.jpg", At(2018, 8, 5, 1, 0, 44.25), false},
                             {"cam0_1533430844250000.jpg", At(2018, 8, 5, 1, 0, 44.25), false}};
  for (const NamedTime& c : cases) {
    const auto found = TimeInName(c.name);
    ASSERT_TRUE(found) << c.name;
    EXPECT_EQ(found->time, c.time) << c.name;
    EXPECT_EQ(found->is_local, c.is_local) << c.name;
  }
}

TEST(TimeInName, TakesNoOtherNumberForATime) {
  for (const char* name :
       {"DJI_0001.JPG", "IMG_20190102.jpg", "20191302_030405.jpg", "20190230_030405.jpg",
        "20190102_250405.jpg", "20190102_036105.jpg", "18500102_030405.jpg", "0000001234.jpg",
        "12345678901.jpg", "20180805010044123456789.jpg", "2019-0102_030405.jpg", "", ".", "Z"}) {
    EXPECT_FALSE(TimeInName(name)) << name;
  }
}

std::vector<Photo> Named(const std::vector<std::string>& names) {
  std::vector<Photo> photos(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) photos[i].name = names[i];
  return photos;
}

TEST(TakeTimesFromNames, GivesThePhotosWithoutATimeTheirs) {
  std::vector<Photo> photos = Named({"IMG_20190102_030405.jpg", "IMG_20190102_030409.jpg"});
  photos[0].captured_at = At(2019, 1, 2, 2, 4, 5);
  EXPECT_EQ(TakeTimesFromNames(photos), 1);
  EXPECT_EQ(photos[0].captured_at, At(2019, 1, 2, 2, 4, 5)) << "metadata stand above the name";
  EXPECT_EQ(photos[1].captured_at, At(2019, 1, 2, 3, 4, 9));
  EXPECT_TRUE(photos[1].captured_at_is_local);
}

TEST(TakeTimesFromNames, BelievesNoNameThatTheOthersContradict) {
  // The start of the flight, a serial number: the same in all names.
  std::vector<Photo> start, serial, counter, few;
  for (int i = 0; i < 20; ++i) {
    const std::string number = std::to_string(1000 + i);
    start.push_back(Named({"20190102_030405_" + number + ".jpg"})[0]);
    serial.push_back(Named({"1533430844_" + number + ".jpg"})[0]);
    counter.push_back(
        Named({"20190102_000" + std::string(i < 10 ? "00" : "0") + std::to_string(i) + ".jpg"})[0]);
    few.push_back(Named({i % 2 == 0 ? "DSC_" + number + ".jpg" : "20190102_03" + number + ".jpg"})[0]);
  }
  for (std::vector<Photo>* photos : {&start, &serial, &counter, &few}) {
    EXPECT_EQ(TakeTimesFromNames(*photos), 0) << photos->front().name;
    EXPECT_FALSE(photos->back().captured_at) << photos->back().name;
  }
}

}  // namespace
}  // namespace skyquilt::flight
