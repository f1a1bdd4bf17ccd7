// What users really drop on it: the good photos make the map, each bad file is named with its reason.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <string>

#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/flight/remarks/remark_words.h"
#include "core/pipeline/build_mosaic.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pyramid/map_memory.h"
#include "core/simulate/simulate_flight.h"
#include "tests/support/bytes_of.h"
#include "tests/support/facts_alone.h"
#include "tests/support/memory_sink.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

using std::filesystem::path;

class BadInput : public testing::Test {
 protected:
  void SetUp() override {
    SilentProgress progress;
    ASSERT_TRUE(simulate::SimulateFlight(Simulated(4), folder_.path(), progress).ok());
    photos_ = folder_ / "photos";
  }
  static simulate::SimulateOptions Simulated(int photos) {
    simulate::SimulateOptions simulated;
    simulated.trajectory.photos = photos;
    simulated.intrinsics = camera::Intrinsics::Centered(400, 300, 320.0);
    simulated.write_world = false;
    return simulated;
  }
  // The first photo of another flight.
  void AddFrom(const simulate::SimulateOptions& other, const std::string& name) {
    SilentProgress progress;
    ASSERT_TRUE(simulate::SimulateFlight(other, folder_ / "other", progress).ok());
    std::filesystem::rename(folder_ / "other/photos/SIM_0001.JPG", photos_ / name);
  }

  void Write(const std::string& name, const std::string& bytes) {
    std::ofstream(photos_ / name, std::ios::binary) << bytes;
  }

  Result<BuiltMosaic> Build(MosaicOptions options = {}, pyramid::MapMemory* memory = nullptr) {
    SilentProgress progress;
    options.method = AlignMethod::kImu;
    const auto files = flight::ListInputFiles({photos_});
    if (!files) return files.error();
    return BuildMosaic(*files, options, flight::FilePhotoSource(), map_, progress, nullptr, memory);
  }

  void ExpectLeftOut(const std::string& name) {
    const auto built = test::ValueOf(Build());
    EXPECT_EQ(built.report.photos_pose_only, 4);
    ASSERT_EQ(built.report.photos_left_out, 1);
    EXPECT_EQ(built.report.left_out_photos[0].name, name);
    EXPECT_GT(InWords(built.report.left_out_photos[0].reason).size(), 15u);
  }

  test::TemporaryFolder folder_;
  path photos_;
  test::MemorySink map_;
};

TEST_F(BadInput, FilesThatAreNoWholeJpegAreLeftOut) {
  const std::string whole = test::BytesOf(photos_ / "SIM_0001.JPG");
  const std::map<std::string, std::string> files = {{"notes.jpg", "remember the batteries\n"},
                                                    {"empty.jpg", ""},
                                                    {"cut.jpg", whole.substr(0, whole.size() * 2 / 3)}};
  for (const auto& [name, bytes] : files) {
    SCOPED_TRACE(name);
    Write(name, bytes);
    ExpectLeftOut(name);
    std::filesystem::remove(photos_ / name);
  }
}

TEST_F(BadInput, AJpegDamagedInTheMiddleNeverFailsTheFlight) {
  std::string bytes = test::BytesOf(photos_ / "SIM_0001.JPG");
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 4000 && i < bytes.size() - 2; ++i)
    bytes[i] = '\xff';
  Write("damaged.jpg", bytes);
  EXPECT_GE(test::ValueOf(Build()).report.photos_pose_only, 4);
}

TEST_F(BadInput, APhotoWithoutGpsIsLeftOut) {
  simulate::SimulateOptions blind = Simulated(1);
  blind.seed = 99;
  blind.noise = simulate::NoiseClass::kNoGps;
  AddFrom(blind, "blind.JPG");
  ExpectLeftOut("blind.JPG");
}

TEST_F(BadInput, OnePhotoMakesAMap) {
  for (const char* name : {"SIM_0002.JPG", "SIM_0003.JPG", "SIM_0004.JPG"})
    std::filesystem::remove(photos_ / name);
  EXPECT_EQ(test::ValueOf(Build()).report.photos_pose_only, 1);
  EXPECT_FALSE(map_.tiles.empty());
}

// One place is too little to bring a map that is aligned anew to.
TEST_F(BadInput, ALonePhotoThatWasPlacedByHandMakesAMapWhereABadOneGoes) {
  for (const char* name : {"SIM_0002.JPG", "SIM_0003.JPG", "SIM_0004.JPG"})
    std::filesystem::remove(photos_ / name);
  Write("notes.jpg", "remember the batteries\n");
  test::FactsAlone memory;
  ASSERT_TRUE(Build({}, &memory).ok());
  auto by_hand = test::ValueOf(ParseFacts(memory.Recall()));
  by_hand.is_by_hand = true;
  ASSERT_TRUE(memory.Remember(WriteFacts(by_hand)).ok());
  std::filesystem::remove(photos_ / "notes.jpg");
  EXPECT_TRUE(Build({}, &memory).ok());
}

TEST_F(BadInput, NothingUsableIsAClearError) {
  for (const auto& entry : std::filesystem::directory_iterator(photos_)) {
    std::ofstream(entry.path(), std::ios::trunc) << "not a photo";
  }
  const Error built = test::ErrorOf(Build());
  EXPECT_EQ(built.code, ErrorCode::kUnprocessable);
  EXPECT_NE(built.message.find("photo"), std::string::npos);
}

TEST_F(BadInput, PhotosOfTwoFarPlacesDoNotMakeAWorldWideMap) {
  simulate::SimulateOptions elsewhere = Simulated(1);
  elsewhere.origin = {-33.0, 151.0};
  AddFrom(elsewhere, "far.JPG");
  ExpectLeftOut("far.JPG");
}

TEST_F(BadInput, WhatLiesInAZoneOfUtmIsRefusedBeyondUtm) {
  std::filesystem::remove_all(photos_);
  std::filesystem::create_directories(photos_);
  simulate::SimulateOptions north = Simulated(1);
  north.origin = {84.5, 7.0};
  AddFrom(north, "north.JPG");
  MosaicOptions utm, heights;
  utm.write_utm = true;
  heights.heights = MapHeights::kSurface;
  for (const MosaicOptions& options : {utm, heights}) {
    const Error refused = test::ErrorOf(Build(options));
    EXPECT_EQ(refused.code, ErrorCode::kUnprocessable);
    EXPECT_NE(refused.message.find("beyond UTM"), std::string::npos) << refused.message;
    EXPECT_TRUE(map_.tiles.empty());
  }
  test::FactsAlone memory;
  EXPECT_TRUE(Build({}, &memory).ok());
  // Nor does a run that goes on from there begin to draw.
  map_.tiles.clear();
  const Error refused = test::ErrorOf(Build(utm, &memory));
  EXPECT_NE(refused.message.find("beyond UTM"), std::string::npos) << refused.message;
  EXPECT_TRUE(map_.tiles.empty());
}

}  // namespace
}  // namespace skyquilt::pipeline
