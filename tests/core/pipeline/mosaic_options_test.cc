// What of the options is a mistake, and how two runs are told apart.
#include "core/pipeline/mosaic_options.h"

#include <gtest/gtest.h>

namespace skyquilt::pipeline {
namespace {

TEST(CheckGsd, AsksAboutMetresThatAreCentimetresMoreLikely) {
  MosaicOptions options;
  EXPECT_TRUE(options.CheckGsd(0.017));
  for (const double gsd_m : {0.001, 0.05, 0.34}) {
    options.gsd_m = gsd_m;
    EXPECT_TRUE(options.CheckGsd(0.017)) << gsd_m;
  }
  options.gsd_m = 5.0;
  const Result<void> asked = options.CheckGsd(0.017);
  ASSERT_FALSE(asked);
  EXPECT_EQ(asked.error().code, ErrorCode::kInvalidArgument);
  for (const char* said : {"5 m", "1.7 cm", "294 times", "5cm", "--any-gsd", "\"any_gsd\": true"})
    EXPECT_NE(asked.error().message.find(said), std::string::npos) << said << ": " << asked.error().message;
  EXPECT_TRUE(options.CheckGsd(0.3));  // a flight so high that it is no mistake
  options.any_gsd = true;
  EXPECT_TRUE(options.CheckGsd(0.017));
}

TEST(MosaicOptions, AreToldApartInWords) {
  const std::map<std::string, std::string> usual = MosaicOptions{}.InWords();
  EXPECT_EQ(usual.at("--method"), "auto");
  EXPECT_EQ(usual.at("--format"), "auto");
  EXPECT_EQ(usual.at("--quality"), "85");
  MosaicOptions options;
  options.method = AlignMethod::kImu;
  options.encoding = image::TileEncoding::kWebp;
  options.readout_s = 0.0;
  options.takeoff_height_amsl_m = 500.0;
  const std::map<std::string, std::string> other = options.InWords();
  EXPECT_EQ(other.at("--method"), "imu");
  EXPECT_EQ(other.at("--format"), "webp");
  EXPECT_EQ(other.at("--readout-ms"), "0");
  EXPECT_NE(other.at("--readout-ms"), usual.at("--readout-ms"));  // none at all is another thing
  EXPECT_EQ(other.at("--takeoff-height-m"), "500");
  EXPECT_EQ(other.size(), usual.size());
  options.threads = 7;
  options.max_memory_bytes *= 2;
  options.title = "Field 7";
  EXPECT_EQ(options.InWords(), other);  // the map is the same
}

TEST(MosaicOptions, AreTakenFromTheWordsOfAMap) {
  MosaicOptions map;
  map.method = AlignMethod::kImages;
  map.surface = MapGround::kDense;
  map.jpeg_quality = 95;
  map.readout_s = 0.0;
  map.takeoff_height_amsl_m = 512.5;
  map.landed_at_start = true;
  map.origin = geo::LatLon{46.8, -7.1234567};
  const auto all = [](const std::string&) { return true; };
  MosaicOptions options;
  options.TakeWords(map.InWords(), all);
  EXPECT_EQ(options.InWords(), map.InWords());
  // What was said now stays.
  MosaicOptions now;
  now.jpeg_quality = 60;
  now.TakeWords(map.InWords(), [](const std::string& name) { return name != "--quality"; });
  EXPECT_EQ(now.jpeg_quality, 60);
  EXPECT_EQ(now.method, AlignMethod::kImages);
  // What this version does not know changes nothing.
  MosaicOptions usual;
  usual.TakeWords({{"--method", "astrology"}, {"--quality", "good"}, {"--origin", "here"}, {"--new", "1"}},
                  all);
  EXPECT_EQ(usual.InWords(), MosaicOptions{}.InWords());
}

}  // namespace
}  // namespace skyquilt::pipeline
