// Reading the two real flights, against exiftool as the oracle where it is installed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/geo/lat_lon.h"
#include "tests/support/output_of.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

namespace fs = std::filesystem;

fs::path ImagesOf(const std::string& flight) {
  const char* root = std::getenv("SKYQUILT_DATA");
  return (root ? fs::path(root) : fs::path(SKYQUILT_SOURCE_DIR) / ".." / "shared" / "data") / flight /
         "images";
}

#define SKIP_WITHOUT(folder) \
  if (!fs::exists(folder)) GTEST_SKIP() << "no sample flight at " << (folder) << "; set SKYQUILT_DATA"

Flight Read(const fs::path& folder, int threads = 0) {
  SilentProgress progress;
  return test::ValueOf(ReadFlight(test::ValueOf(ListInputFiles({folder})), threads, progress));
}

// Rows of exiftool's printed numbers by file name.
std::map<std::string, std::vector<std::string>> AskExiftool(const fs::path& folder, const std::string& tags) {
  std::map<std::string, std::vector<std::string>> rows;
  const std::string command = "exiftool -n -T -filename " + tags + " '" + folder.string() + "' 2>/dev/null";
  std::istringstream lines(test::OutputOf(command));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::string name, field;
    std::getline(fields, name, '\t');
    while (std::getline(fields, field, '\t')) rows[name].push_back(field);
  }
  return rows;
}

std::string Printed(const UtcTime& time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  char text[32];
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  std::strftime(text, sizeof text, "%Y:%m:%d %H:%M:%S", &parts);
  return text;
}

double WrappedDeg(double deg) { return geo::RadToDeg(geo::WrapRad(geo::DegToRad(deg))); }

TEST(ReadFlight, AgreesWithExiftoolOnTheDjiFlight) {
  const fs::path folder = ImagesOf("brighton_beach");
  SKIP_WITHOUT(folder);
  const auto rows =
      AskExiftool(folder,
                  "-gpslatitude -gpslongitude -absolutealtitude -relativealtitude -gimbalyawdegree "
                  "-gimbalpitchdegree -gimbalrolldegree -datetimeoriginal -exposuretime -imagewidth "
                  "-imageheight");
  if (rows.empty()) GTEST_SKIP() << "exiftool is not installed";
  const Flight flight = Read(folder);
  ASSERT_EQ(flight.photos.size(), rows.size());
  EXPECT_TRUE(flight.left_out.empty());
  for (const Photo& photo : flight.photos) {
    SCOPED_TRACE(photo.name);
    const auto& row = rows.at(photo.name);
    ASSERT_TRUE(photo.position && photo.attitude && photo.captured_at);
    EXPECT_NEAR(photo.position->position.lat_deg, std::stod(row[0]), 1e-9);
    EXPECT_NEAR(photo.position->position.lon_deg, std::stod(row[1]), 1e-9);
    EXPECT_NEAR(photo.position->height_amsl_m.value(), std::stod(row[2]), 1e-6);
    EXPECT_NEAR(photo.position->height_above_takeoff_m.value(), std::stod(row[3]), 1e-6);
    EXPECT_EQ(photo.attitude->kind, AttitudeKind::kGimbal);
    EXPECT_NEAR(geo::RadToDeg(photo.attitude->yaw_rad), std::stod(row[4]), 1e-6);
    EXPECT_NEAR(geo::RadToDeg(photo.attitude->pitch_rad), std::stod(row[5]), 1e-6);
    EXPECT_NEAR(geo::RadToDeg(photo.attitude->roll_rad), std::stod(row[6]), 1e-6);
    EXPECT_EQ(Printed(*photo.captured_at), row[7]);
    EXPECT_TRUE(photo.captured_at_is_local);
    EXPECT_NEAR(photo.exposure_time_s.value(), std::stod(row[8]), 1e-6);
    EXPECT_EQ(photo.intrinsics.width_px, std::stoi(row[9]));
    EXPECT_EQ(photo.intrinsics.height_px, std::stoi(row[10]));
    EXPECT_EQ(photo.focal_source, FocalSource::kSensorTable);
    EXPECT_NEAR(photo.intrinsics.focal_x_px, 3.61 / 6.17 * 4000, 1.0);
    EXPECT_EQ(photo.make, "DJI");
    EXPECT_EQ(photo.camera_key, flight.photos[0].camera_key);
  }
}

TEST(ReadFlight, AgreesWithExiftoolOnTheFixedWingFlight) {
  const fs::path folder = ImagesOf("seneca_40");
  SKIP_WITHOUT(folder);
  const auto rows = AskExiftool(folder,
                                "-gpslatitude -gpslongitude -xmp:altitudeamsl -xmp:altitudewgs84 -xmp:height "
                                "-xmp:heading -xmp:pitchangle -xmp:rollangle -xmp:utctime");
  if (rows.empty()) GTEST_SKIP() << "exiftool is not installed";
  const Flight flight = Read(folder);
  ASSERT_EQ(flight.photos.size(), rows.size());
  for (const Photo& photo : flight.photos) {
    SCOPED_TRACE(photo.name);
    const auto& row = rows.at(photo.name);
    ASSERT_TRUE(photo.position && photo.attitude && photo.captured_at);
    // EXIF and XMP print the same position to 1e-8 degrees.
    EXPECT_NEAR(photo.position->position.lat_deg, std::stod(row[0]), 2e-8);
    EXPECT_NEAR(photo.position->position.lon_deg, std::stod(row[1]), 2e-8);
    EXPECT_NEAR(photo.position->height_amsl_m.value(), std::stod(row[2]), 1e-6);
    EXPECT_NEAR(photo.position->height_ellipsoid_m.value(), std::stod(row[3]), 1e-6);
    EXPECT_NEAR(photo.position->height_above_takeoff_m.value(), std::stod(row[4]), 1e-6);
    EXPECT_EQ(photo.attitude->kind, AttitudeKind::kAirframe);
    EXPECT_NEAR(geo::RadToDeg(photo.attitude->yaw_rad), WrappedDeg(std::stod(row[5])), 1e-9);
    EXPECT_NEAR(geo::RadToDeg(photo.attitude->pitch_rad), std::stod(row[6]), 1e-9);
    EXPECT_NEAR(geo::RadToDeg(photo.attitude->roll_rad), std::stod(row[7]), 1e-9);
    EXPECT_EQ(Printed(*photo.captured_at), row[8]);
    EXPECT_FALSE(photo.captured_at_is_local);
    EXPECT_NEAR(photo.intrinsics.focal_x_px, 2775.3, 1.0);
  }
}

TEST(ReadFlight, PutsPhotosInTheOrderOfCaptureWhateverTheThreads) {
  const fs::path folder = ImagesOf("brighton_beach");
  SKIP_WITHOUT(folder);
  const Flight one = Read(folder, 1);
  const Flight four = Read(folder, 4);
  ASSERT_EQ(one.photos.size(), four.photos.size());
  for (std::size_t i = 0; i < one.photos.size(); ++i) {
    EXPECT_EQ(one.photos[i].name, four.photos[i].name);
    EXPECT_EQ(one.photos[i].notes, four.photos[i].notes);
    if (i > 0) {
      EXPECT_LE(one.photos[i - 1].captured_at, one.photos[i].captured_at);
    }
  }
  EXPECT_EQ(one.warnings, four.warnings);
}

TEST(ReadFlight, SaysWhichPhotosAViewerSavedAgain) {
  const fs::path folder = ImagesOf("brighton_beach");
  SKIP_WITHOUT(folder);
  const Flight flight = Read(folder);
  std::set<std::string> noted;
  for (const Photo& photo : flight.photos) {
    if (photo.is_resaved_by_viewer) noted.insert(photo.name);
  }
  EXPECT_EQ(noted, (std::set<std::string>{"DJI_0024.JPG", "DJI_0025.JPG", "DJI_0026.JPG", "DJI_0027.JPG",
                                          "DJI_0028.JPG", "DJI_0029.JPG"}));
}

TEST(FilePhotoSource, DecodesEveryRealPhotoSmall) {
  for (const char* name : {"brighton_beach", "seneca_40"}) {
    const fs::path folder = ImagesOf(name);
    SKIP_WITHOUT(folder);
    for (const Photo& photo : Read(folder).photos) {
      const auto image = FilePhotoSource().Decode(photo, 8);
      ASSERT_TRUE(image.ok()) << photo.name << ": " << image.error().message;
      EXPECT_EQ(image->width_px, (photo.intrinsics.width_px + 7) / 8);
      EXPECT_EQ(image->height_px, (photo.intrinsics.height_px + 7) / 8);
    }
  }
}

}  // namespace
}  // namespace skyquilt::flight
