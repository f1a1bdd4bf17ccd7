#include "core/simulate/simulate_flight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "core/camera/footprint.h"
#include "core/flight/read_flight.h"
#include "core/geo/web_mercator.h"
#include "core/simulate/world/world_raster.h"
#include "tests/support/bytes_of.h"
#include "tests/support/output_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::simulate {
namespace {

class SimulateFlightTest : public testing::Test {
 protected:
  static SimulateOptions Small() {
    SimulateOptions options;
    options.intrinsics = camera::Intrinsics::Centered(400, 300, 300.0);
    options.intrinsics.k1 = -0.1;
    options.intrinsics.k2 = 0.02;
    options.intrinsics.p1 = 0.001;
    options.intrinsics.center_x_px += 3.25;
    options.trajectory.photos = 4;
    options.trajectory.height_m = 40.0;
    options.trajectory.max_tilt_rad = geo::DegToRad(15.0);
    options.trajectory.yaw_rule = YawRule::kAnywhere;
    return options;
  }

  const test::TemporaryFolder folder_;
};

bool HasProgram(const std::string& name) {
  return std::system(("command -v " + name + " > /dev/null 2>&1").c_str()) == 0;
}

TEST_F(SimulateFlightTest, WritesTheSameBytesOnAnyNumberOfThreads) {
  SimulateOptions options = Small();
  options.noise = NoiseClass::kXmpTypical;
  SilentProgress progress;
  options.threads = 1;
  ASSERT_TRUE(SimulateFlight(options, folder_ / "a", progress).ok());
  options.threads = 2;
  ASSERT_TRUE(SimulateFlight(options, folder_ / "b", progress).ok());
  for (const char* name :
       {"photos/SIM_0001.JPG", "photos/SIM_0004.JPG", "truth/poses.json", "truth/world.tif"}) {
    const std::string a = test::BytesOf(folder_ / "a" / name);
    EXPECT_GT(a.size(), 1000u) << name;
    EXPECT_TRUE(a == test::BytesOf(folder_ / "b" / name)) << name;
  }
}

// The largest distance, in pixels, between where the recorded pose and the true pose put ground points.
double RecordedAgainstTruePx(const SimulatedFlight& flight, const flight::Photo& photo,
                             const SimulatedPhoto& truth) {
  const geo::Wgs84 at{photo.position->position.lat_deg, photo.position->position.lon_deg,
                      flight.frame.origin().height_ellipsoid_m + *photo.position->height_above_takeoff_m};
  const geo::Rigid3 recorded = geo::Rigid3::FromRotationAndTargetOrigin(
      CamFromEnuOfGimbal({photo.attitude->yaw_rad, photo.attitude->pitch_rad, photo.attitude->roll_rad}),
      flight.frame.EnuFromWgs84(at));
  double largest = 0.0;
  for (int y = 0; y < 300; y += 30) {
    for (int x = 0; x < 400; x += 40) {
      const auto ground = camera::GroundFromPixel(flight.options.intrinsics, truth.pose.cam_from_enu,
                                                  Eigen::Vector2d(x, y), 0.0);
      if (!ground) return 1e9;
      const auto pixel = photo.intrinsics.Project(recorded * *ground);
      if (!pixel) return 1e9;
      largest = std::max(largest, (*pixel - Eigen::Vector2d(x, y)).norm());
    }
  }
  return largest;
}

TEST_F(SimulateFlightTest, ExactPhotosReadBackToAHundredthOfAPixel) {
  for (const double lat_deg : {-60.0, 0.0, 68.0}) {
    SimulateOptions options = Small();
    options.origin = {lat_deg, -71.5};
    options.write_world = false;
    SilentProgress progress;
    const auto flight = test::ValueOf(SimulateFlight(options, folder_.path(), progress));
    for (const SimulatedPhoto& truth : flight.photos) {
      const auto photo = test::ValueOf(flight::ReadPhoto({truth.photo.name, truth.photo.path}));
      ASSERT_TRUE(photo.position && photo.attitude && photo.position->height_above_takeoff_m);
      EXPECT_LT(RecordedAgainstTruePx(flight, photo, truth), 0.01);
      EXPECT_EQ(photo.captured_at, truth.recorded.captured_at);
      EXPECT_FALSE(photo.captured_at_is_local);
      EXPECT_EQ(photo.focal_source, flight::FocalSource::kDewarpData);
      EXPECT_LT(RecordedAgainstTruePx(flight, truth.photo, truth), 0.01) << "the photo made without a file";
    }
  }
}

TEST_F(SimulateFlightTest, NoiseClassesLeaveOutAndDisturbWhatTheyName) {
  SimulateOptions options = Small();
  options.trajectory.photos = 400;
  const auto measure = [&options](NoiseClass noise) {
    options.noise = noise;
    double squared = 0.0;
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
      options.seed = seed;
      const auto flight = PlanSimulatedFlight(options);
      for (const SimulatedPhoto& photo : flight->photos) {
        const Eigen::Vector3d error = flight->frame.EnuFromWgs84(*photo.recorded.position) -
                                      photo.pose.cam_from_enu.TargetOriginInSource();
        squared += error.head<2>().squaredNorm() / static_cast<double>(flight->photos.size() * 10);
      }
    }
    return std::sqrt(squared);
  };
  EXPECT_LT(measure(NoiseClass::kExact), 1e-6);
  EXPECT_NEAR(measure(NoiseClass::kXmpTypical), 1.5, 0.5);
  EXPECT_NEAR(measure(NoiseClass::kRtk), 0.02, 0.008);
  options.noise = NoiseClass::kNoAttitude;
  EXPECT_FALSE(PlanSimulatedFlight(options)->photos[0].photo.attitude.has_value());
  options.noise = NoiseClass::kNoGps;
  const auto no_gps = PlanSimulatedFlight(options);
  EXPECT_FALSE(no_gps->photos[0].photo.position.has_value());
  EXPECT_TRUE(no_gps->photos[0].photo.attitude.has_value());
}

TEST_F(SimulateFlightTest, ExiftoolReadsTheTags) {
  if (!HasProgram("exiftool")) GTEST_SKIP() << "exiftool is not installed";
  SimulateOptions options = Small();
  options.origin = {-33.25, -70.5};
  options.write_world = false;
  SilentProgress progress;
  const auto flight = test::ValueOf(SimulateFlight(options, folder_.path(), progress));
  const SimulatedPhoto& truth = flight.photos[1];
  const std::string lines = test::OutputOf(
      "exiftool -n -s3 -GPSLatitude -GPSLongitude -RelativeAltitude -GimbalPitchDegree "
      "-Model -SubSecDateTimeOriginal -warning " +
      truth.photo.path.string());
  double lat = 0.0, lon = 0.0, relative = 0.0, pitch = 0.0;
  ASSERT_EQ(std::sscanf(lines.c_str(), "%lf\n%lf\n%lf\n%lf", &lat, &lon, &relative, &pitch), 4) << lines;
  EXPECT_NEAR(lat, truth.recorded.position->lat_deg, 1e-8);
  EXPECT_NEAR(lon, truth.recorded.position->lon_deg, 1e-8);
  EXPECT_NEAR(relative, *truth.recorded.height_above_takeoff_m, 1e-4);
  EXPECT_NEAR(pitch, geo::RadToDeg(truth.recorded.gimbal->pitch_rad), 1e-6);
  EXPECT_NE(lines.find("Skyquilt Simulator"), std::string::npos);
  EXPECT_NE(lines.find("2024:06:01 10:00:0"), std::string::npos);
  EXPECT_EQ(lines.find("arning"), std::string::npos) << lines;
}

TEST_F(SimulateFlightTest, GdalFindsSurveyMarksOfTheTruthMapAtTheirPlaces) {
  if (!HasProgram("gdallocationinfo")) GTEST_SKIP() << "GDAL's command line tools are not installed";
  SimulateOptions options = Small();
  options.origin = {46.8, 7.1};
  options.world.mark_spacing_m = 8.0;
  options.world.mark_radius_m = 0.5;
  SilentProgress progress;
  const auto flight = test::ValueOf(SimulateFlight(options, folder_.path(), progress));
  for (const Eigen::Vector2d& mark :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(16, -8), Eigen::Vector2d(-8, 8)}) {
    for (const Eigen::Vector2d& off : {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.3, 0),
                                       Eigen::Vector2d(0.75, 0), Eigen::Vector2d(0, -0.75)}) {
      const geo::Wgs84 at = flight.frame.Wgs84FromEnu({mark.x() + off.x(), mark.y() + off.y(), 0.0});
      char place[80];
      std::snprintf(place, sizeof place, "%.10f %.10f", at.lon_deg, at.lat_deg);
      const std::string value = test::OutputOf("gdallocationinfo -valonly -b 2 -wgs84 " +
                                               (folder_ / "truth/world.tif").string() + " " + place);
      ASSERT_FALSE(value.empty());
      if (off.norm() < 0.4) {
        EXPECT_GT(std::stoi(value), 230) << place;
      } else {
        EXPECT_LT(std::stoi(value), 30) << place;
      }
    }
  }
  // The grid is that of the tiles: the corner is a whole number of pixels from the square's corner.
  const geo::RasterFrame raster = flight.WorldRaster();
  const double columns =
      (raster.north_west_in_merc.x() + geo::kMercHalfWidthM) / raster.pixel_size_in_merc_m / kWorldTilePx;
  EXPECT_NEAR(columns, std::round(columns), 1e-6);
}

TEST_F(SimulateFlightTest, TheMapOfAFlightAcrossTheAntimeridianIsNoLarger) {
  SimulateOptions options = Small();
  options.origin = {-17.0, 170.0};
  const geo::RasterFrame elsewhere = test::ValueOf(PlanSimulatedFlight(options)).WorldRaster();
  for (const double lon_deg : {180.0, -180.0, 179.9999, -179.9999}) {
    options.origin.lon_deg = lon_deg;
    const geo::RasterFrame raster = test::ValueOf(PlanSimulatedFlight(options)).WorldRaster();
    EXPECT_NEAR(raster.width_px, elsewhere.width_px, kWorldTilePx) << lon_deg;
    EXPECT_EQ(raster.height_px, elsewhere.height_px) << lon_deg;
  }
}

TEST_F(SimulateFlightTest, SourceGivesThePicturesOfTheFiles) {
  const auto flight = test::ValueOf(PlanSimulatedFlight(Small()));
  const SimulatedPhotoSource source(flight);
  const auto full = source.Decode(flight.photos[2].photo, 1);
  const auto quarter = source.Decode(flight.photos[2].photo, 4);
  ASSERT_TRUE(full.ok() && quarter.ok());
  EXPECT_EQ(full->width_px, 400);
  EXPECT_EQ(quarter->width_px, 100);
  EXPECT_EQ(quarter->height_px, 75);
  double mean = 0.0;
  for (int y = 40; y < 44; ++y) {
    for (int x = 80; x < 84; ++x) mean += full->Row(y)[3 * x] / 16.0;
  }
  EXPECT_NEAR(quarter->Row(10)[3 * 20], mean, 0.51);
  flight::Photo stranger;
  stranger.name = "other.jpg";
  EXPECT_EQ(source.Decode(stranger, 1).error().code, ErrorCode::kNotFound);
}

TEST_F(SimulateFlightTest, FlownWithARecorderItWritesLogsAndPhotosOfOneClock) {
  SimulateOptions options = Small();
  options.noise = NoiseClass::kNoGps;
  options.clock = {3607.3, true};
  options.survey.emplace();
  options.log_formats = {LogFormat::kDataflash, LogFormat::kUlog, LogFormat::kCsv};
  options.write_world = false;
  SilentProgress progress;
  const auto flight = test::ValueOf(SimulateFlight(options, folder_.path(), progress));
  for (const char* name : {"flight.BIN", "flight.ulg", "flight.csv"}) {
    EXPECT_GT(std::filesystem::file_size(folder_ / "logs" / name), 100000u) << name;
  }
  ASSERT_TRUE(flight.log.has_value());
  ASSERT_EQ(flight.log->events.size(), flight.photos.size());
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    const SimulatedPhoto& truth = flight.photos[i];
    EXPECT_NEAR(flight.log->events[i].t_s, truth.pose.t_s, 0.003);
    const auto photo = test::ValueOf(flight::ReadPhoto({truth.photo.name, truth.photo.path}));
    EXPECT_FALSE(photo.position.has_value());
    EXPECT_TRUE(photo.captured_at_is_local);
    ASSERT_TRUE(photo.captured_at.has_value());
    const double behind_s =
        std::chrono::duration<double>(options.start - *photo.captured_at).count() + 3607.3 + truth.pose.t_s;
    EXPECT_GE(behind_s, -1e-6);
    EXPECT_LT(behind_s, 1.0) << "truncated to whole seconds";
  }
}

TEST_F(SimulateFlightTest, SaysWhatIsWrongWithImpossibleOptions) {
  SilentProgress progress;
  SimulateOptions options = Small();
  options.origin.lat_deg = 89.0;
  EXPECT_EQ(PlanSimulatedFlight(options).error().code, ErrorCode::kInvalidArgument);
  options = Small();
  options.intrinsics.k1 = -2.0;
  EXPECT_NE(PlanSimulatedFlight(options).error().message.find("k1"), std::string::npos);
  options = Small();
  options.world.relief_m = 100.0;
  EXPECT_EQ(PlanSimulatedFlight(options).error().code, ErrorCode::kInvalidArgument);
  for (const double time_s : {-0.005, 11.0, std::nan("")}) {
    options = Small();
    options.readout_s = time_s;
    EXPECT_EQ(PlanSimulatedFlight(options).error().code, ErrorCode::kInvalidArgument);
    options = Small();
    options.shutter_s = time_s;
    EXPECT_EQ(PlanSimulatedFlight(options).error().code, ErrorCode::kInvalidArgument);
  }
  options = Small();
  const auto blocked = folder_ / "blocked";
  { std::ofstream(blocked.string()) << "a file, not a folder"; }
  EXPECT_EQ(SimulateFlight(options, blocked, progress).error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace skyquilt::simulate
