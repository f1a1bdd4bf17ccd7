// Flights that no survey is like, through the whole pipeline: each ends with a map or with a refusal that
// says of which photos and why, and never with the end of the program.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/flight/remarks/remark_words.h"
#include "core/pipeline/build_mosaic.h"
#include "core/simulate/writers/write_photo.h"
#include "tests/support/memory_sink.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

struct Shot {
  geo::LatLon at{46.8, 7.1};
  double height_m = 50.0;
  double pitch_deg = -90.0, yaw_deg = 0.0;
  int width_px = 320, height_px = 240;
  int plain = -1;  // a grey level all over; -1: what the ground looks like
  bool is_rtk = false;
};

geo::LatLon Beside(const geo::LatLon& at, double east_m, double north_m) {
  const geo::Wgs84 there =
      geo::LocalFrame({at.lat_deg, at.lon_deg, 0.0}).Wgs84FromEnu({east_m, north_m, 0.0});
  return {there.lat_deg, there.lon_deg};
}

// Spots of three sizes, the same wherever they are seen from.
std::uint8_t GreyAt(double east_m, double north_m, int channel) {
  double grey = 128.0;
  for (const double size_m : {0.7, 2.3, 9.0}) {
    const auto x = static_cast<std::uint32_t>(std::lround(east_m / size_m));
    const auto y = static_cast<std::uint32_t>(std::lround(north_m / size_m));
    std::uint32_t hash = x * 374761393U + y * 668265263U + static_cast<std::uint32_t>(channel) * 97U;
    hash = (hash ^ (hash >> 13)) * 1274126177U;
    grey += 30.0 * (static_cast<double>((hash >> 8) & 0xffff) / 65535.0 - 0.5) * 2.0;
  }
  return static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
}

image::DecodedImage Picture(const Shot& shot, const geo::LatLon& origin) {
  image::DecodedImage image;
  image.width_px = shot.width_px;
  image.height_px = shot.height_px;
  image.rgb.resize(3 * static_cast<std::size_t>(shot.width_px) * static_cast<std::size_t>(shot.height_px));
  const Eigen::Vector3d center = geo::LocalFrame({origin.lat_deg, origin.lon_deg, 0.0})
                                     .EnuFromWgs84({shot.at.lat_deg, shot.at.lon_deg, 0.0});
  const double gsd_m = std::abs(shot.height_m) / 300.0;
  std::size_t k = 0;
  for (int y = 0; y < shot.height_px; ++y) {
    for (int x = 0; x < shot.width_px; ++x) {
      for (int c = 0; c < 3; ++c, ++k) {
        image.rgb[k] = shot.plain >= 0 ? static_cast<std::uint8_t>(shot.plain)
                       : std::isfinite(gsd_m) && gsd_m < 1e3
                           ? GreyAt(std::remainder(center.x(), 1e6) + gsd_m * (x - shot.width_px / 2),
                                    std::remainder(center.y(), 1e6) - gsd_m * (y - shot.height_px / 2), c)
                           : static_cast<std::uint8_t>(k * 7919 >> 3);
      }
    }
  }
  return image;
}

class DegenerateFlights : public testing::Test {
 protected:
  void Add(const Shot& shot) {
    simulate::RecordedPose recorded;
    recorded.position = geo::Wgs84{shot.at.lat_deg, shot.at.lon_deg, 500.0 + shot.height_m};
    recorded.height_above_takeoff_m = shot.height_m;
    recorded.gimbal = simulate::YawPitchRoll{geo::DegToRad(shot.yaw_deg), geo::DegToRad(shot.pitch_deg), 0.0};
    recorded.intrinsics = camera::Intrinsics::Centered(shot.width_px, shot.height_px, 300.0);
    recorded.is_rtk_fixed = shot.is_rtk;
    recorded.captured_at = flight::UtcTime(std::chrono::seconds(1717236000 + 2 * count_));
    if (count_ == 0) origin_ = shot.at;
    const std::string name = "P" + std::to_string(100 + count_++) + ".JPG";
    ASSERT_TRUE(
        simulate::WriteBytes(folder_ / name, simulate::EncodePhoto(Picture(shot, origin_), recorded)).ok());
  }
  void AddLine(int photos, double step_m, Shot shot = {}) {
    const geo::LatLon start = shot.at;
    for (int i = 0; i < photos; ++i) {
      shot.at = Beside(start, 0.0, i * step_m);
      Add(shot);
    }
  }

  Result<BuiltMosaic> Build(AlignMethod method) {
    SilentProgress progress;
    MosaicOptions options;
    options.method = method;
    options.threads = 2;
    const auto files = flight::ListInputFiles({folder_.path()});
    if (!files) return files.error();
    map_ = {};
    return BuildMosaic(*files, options, flight::FilePhotoSource(), map_, progress);
  }

  static void ExpectEveryPhotoAccountedFor(const MosaicReport& report, int photos) {
    EXPECT_EQ(report.photos_aligned + report.photos_pose_only + report.photos_left_out, photos);
    for (const flight::LeftOutPhoto& photo : report.left_out_photos)
      EXPECT_GT(InWords(photo.reason).size(), 15U);
    EXPECT_LT(report.peak_memory_bytes, std::int64_t{3} << 30);
    EXPECT_LE(report.tile_size_px, 4096);
  }

  void ExpectMap(int left_out = 0) {
    for (const AlignMethod method : {AlignMethod::kAuto, AlignMethod::kImu}) {
      const auto built = test::ValueOf(Build(method));
      EXPECT_GT(map_.tiles.size(), 0U);
      ExpectEveryPhotoAccountedFor(built.report, count_);
      if (method == AlignMethod::kImu) {
        EXPECT_EQ(built.report.photos_left_out, left_out);
      }
    }
  }
  void ExpectMapOfSome() {
    for (const AlignMethod method : {AlignMethod::kAuto, AlignMethod::kImu}) {
      const auto built = test::ValueOf(Build(method));
      ExpectEveryPhotoAccountedFor(built.report, count_);
    }
  }
  void ExpectRefusal(const std::string& words) {
    for (const AlignMethod method : {AlignMethod::kAuto, AlignMethod::kImu}) {
      const Error built = test::ErrorOf(Build(method));
      EXPECT_NE(built.message.find(words), std::string::npos) << built.message;
    }
  }

  test::TemporaryFolder folder_;
  geo::LatLon origin_;
  int count_ = 0;
  test::MemorySink map_;
};

TEST_F(DegenerateFlights, OnePhoto) {
  Add({});
  ExpectMap();
}

TEST_F(DegenerateFlights, OnePhotoLookingAtTheHorizon) {
  Add({.pitch_deg = 5.0});
  ExpectRefusal("look");
}

TEST_F(DegenerateFlights, ManyPhotosOnOneSpot) {
  for (int i = 0; i < 9; ++i) Add({.yaw_deg = 40.0 * i});
  ExpectMap();
}

TEST_F(DegenerateFlights, OneLine) {
  AddLine(8, 10.0);
  ExpectMap();
}

TEST_F(DegenerateFlights, NoOverlap) {
  AddLine(6, 900.0);
  ExpectMap();
}

TEST_F(DegenerateFlights, LongThinPhotos) {
  AddLine(4, 2.0, {.width_px = 2400, .height_px = 800});
  AddLine(4, 2.0, {.width_px = 800, .height_px = 2400});
  ExpectMap();
}

TEST_F(DegenerateFlights, PhotosThinnerThanCamerasTakeThem) {
  AddLine(4, 2.0, {.width_px = 9000, .height_px = 16});
  AddLine(4, 2.0, {.width_px = 16, .height_px = 9000});
  ExpectRefusal("None of the 8 files given is a photo that a map can be made of.");
  ExpectRefusal("panorama");
}

TEST_F(DegenerateFlights, TheSmallestPhotos) {
  AddLine(5, 10.0, {.width_px = 16, .height_px = 16});
  ExpectMap();
}

TEST_F(DegenerateFlights, PhotosOfThreePixels) {
  AddLine(3, 1.0, {.width_px = 3, .height_px = 3});
  AddLine(3, 1.0, {.width_px = 1, .height_px = 400});
  EXPECT_GT(test::ErrorOf(Build(AlignMethod::kAuto)).message.size(), 30U);
}

TEST_F(DegenerateFlights, BlackAndWhite) {
  AddLine(4, 10.0, {.plain = 0});
  AddLine(4, 10.0, {.plain = 255});
  ExpectMap();
}

TEST_F(DegenerateFlights, HorizonInView) {
  AddLine(3, 10.0);
  AddLine(3, 10.0, {.pitch_deg = -20.0});
  AddLine(2, 10.0, {.pitch_deg = 0.0});
  AddLine(2, 10.0, {.pitch_deg = 60.0});
  ExpectMap();
}

TEST_F(DegenerateFlights, TwoPlacesAThousandKilometresApart) {
  AddLine(2, 10.0);
  AddLine(3, 10.0, {.at = {55.0, 12.0}});
  ExpectMap(2);
}

TEST_F(DegenerateFlights, TwoPhotosAThousandKilometresApart) {
  Add({});
  Add({.at = {55.0, 12.0}});
  ExpectMap(1);
}

TEST_F(DegenerateFlights, AcrossTheDateLine) {
  for (int i = -3; i <= 3; ++i) Add({.at = Beside({-17.0, 180.0}, 10.0 * i, 0.0)});
  ExpectMap();
}

// From whichever side photos come, bounds begin in the west and go on beyond 180 degrees.
TEST_F(DegenerateFlights, AcrossTheDateLineFromTheEast) {
  for (int i = 5; i >= -2; --i) Add({.at = Beside({-17.0, -180.0}, 10.0 * i, 0.0)});
  const auto built = test::ValueOf(Build(AlignMethod::kImu));
  const geo::LatLonBounds& bounds = built.report.bounds;
  EXPECT_GT(bounds.west_deg, 179.0);
  EXPECT_LE(bounds.west_deg, 180.0);
  EXPECT_GT(bounds.east_deg, 180.0);
  EXPECT_LT(bounds.east_deg, 181.0);
}

TEST_F(DegenerateFlights, NearThePoles) {
  for (const double lat_deg : {89.999, -89.9999, 85.3}) {
    for (int i = 0; i < 3; ++i) Add({.at = {lat_deg, 20.0 * i}});
  }
  ExpectRefusal("beyond 85 degrees");
}

TEST_F(DegenerateFlights, JustWhereWebMapsEnd) {
  AddLine(4, 10.0, {.at = {84.9, 7.0}});
  ExpectMap();
}

TEST_F(DegenerateFlights, HeightsThatAreNoNumbers) {
  AddLine(3, 10.0);
  Add({.height_m = kNan});
  Add({.height_m = kInf});
  Add({.height_m = -kInf});
  Add({.height_m = 1e300});
  ExpectMapOfSome();
}

TEST_F(DegenerateFlights, AnglesThatAreNoNumbers) {
  AddLine(3, 10.0);
  Add({.pitch_deg = kNan});
  Add({.pitch_deg = kInf, .yaw_deg = kNan});
  ExpectMapOfSome();
}

// Surveyed heights against another zero: all lie 47 m below the ground, or a hand's breadth above it.
TEST_F(DegenerateFlights, BelowTheGround) {
  AddLine(8, 10.0, {.height_m = -47.0, .is_rtk = true});
  for (const AlignMethod method : {AlignMethod::kAuto, AlignMethod::kImu}) {
    const auto built = Build(method);
    if (!built) {
      EXPECT_NE(built.error().message.find("P10"), std::string::npos) << built.error().message;
      continue;
    }
    ExpectEveryPhotoAccountedFor(built->report, count_);
    EXPECT_GT(built->report.gsd_m, 0.005);
  }
}

TEST_F(DegenerateFlights, OneAsHighAsASatellite) {
  AddLine(6, 10.0);
  Add({.height_m = 30'000.0});
  Add({.height_m = 2e6});
  ExpectMap(2);
}

TEST_F(DegenerateFlights, OnTheGround) {
  AddLine(6, 1.0, {.height_m = 1.2});
  ExpectMap();
}

}  // namespace
}  // namespace skyquilt::pipeline
