// SimulateFlight: a whole survey with known truth. PlanSimulatedFlight decides where every photo is taken and
// what is recorded of it; RenderSimulatedPhoto makes its picture; SimulatedPhotoSource hands the pictures to
// a stage without any file; SimulateFlight writes photos and truth into a folder. Frame: enu at
// options.origin; the flat ground is z = 0, at options.takeoff_height_ellipsoid_m over the ellipsoid.
// Deterministic: the same options give the same bytes on any number of threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/intrinsics.h"
#include "core/flight/photo.h"
#include "core/flight/photos/photo_source.h"
#include "core/geo/local_frame.h"
#include "core/geo/raster_frame.h"
#include "core/image/decoded_image.h"
#include "core/simulate/sensors/band_rig.h"
#include "core/simulate/sensors/logged_survey.h"
#include "core/simulate/sensors/recorded_pose.h"
#include "core/simulate/sensors/trajectory.h"
#include "core/simulate/world/render_photo.h"
#include "core/simulate/world/world.h"

namespace skyquilt::simulate {

enum class LogFormat { kDataflash, kUlog, kCsv };

struct SimulateOptions {
  geo::LatLon origin{46.8, 7.1};  // take-off, the middle of the block
  double takeoff_height_ellipsoid_m = 500.0;
  std::uint32_t seed = 1;        // of the flight: trajectory, noise (the world has its own, world.seed)
  WorldOptions world;            // its objects are placed where the flight's photos look at
  TrajectoryOptions trajectory;  // its seed is replaced by `seed`
  camera::Intrinsics intrinsics = camera::Intrinsics::Centered(1600, 1200, 1200.0);
  NoiseClass noise = NoiseClass::kExact;
  CameraClock clock;
  flight::UtcTime start{std::chrono::seconds(1717236000)};  // 2024-06-01 10:00:00 UTC
  // Flown by a simulated aircraft with its recorder running: photos are taken where it really was. Its plan
  // is `trajectory`; the log's clock begins at `start`.
  std::optional<SurveyOptions> survey;
  std::vector<LogFormat> log_formats;  // written into out_dir/logs: flight.BIN, flight.ulg, flight.csv
  double vignetting = 0.0;             // share of light lost in the corners
  double exposure_jitter = 0.0;        // 1-sigma of each photo's brightness, relative
  bool is_exposure_recorded = false;   // its exposure time says so
  double hot_spot = 0.0;               // share by which ground is brighter with the sun right behind
  double hot_spot_rad = 0.2;           // how far from there it is half of that: here a canopy's
  double noise_counts = 1.0;           // sensor noise, 8-bit counts
  double shutter_s = 0.0;              // 0 = no motion blur
  double readout_s = 0.0;              // from the first row to the last; 0 = all rows at once
  double shaking_radps = 0.0;          // 1-sigma of how fast the camera turns while rows are read
  bool has_gyro = false;               // it records that, and the readout time
  bool has_band_rig = false;           // a camera of five bands in place of one in colours
  int jpeg_quality = 92;
  bool write_world = true;
  bool write_surface = false;               // the true heights
  double largest_world_megapixels = 400.0;  // above it the truth map takes a coarser zoom
  int threads = 0;                          // 0 = all cores

  Result<void> Validate() const;
};

struct SimulatedPhoto {
  TruePose pose;
  RecordedPose recorded;
  flight::Photo photo;  // as it is read back from the file; named like the file
  RenderPhotoOptions render;
};

struct SimulatedFlight {
  SimulateOptions options;
  geo::LocalFrame frame{geo::Wgs84{}};
  World world{WorldOptions{}};
  std::vector<SimulatedPhoto> photos;
  std::optional<flight::FlightLog> log;  // of a flight with a survey
  std::vector<RigBand> rig;  // of a flight with one; its photos are then those of the reference band

  double GsdM() const { return options.trajectory.height_m / options.intrinsics.MeanFocalPx(); }
  // Whole Web Mercator tiles that cover all footprints, at the zoom that fits the photos.
  geo::RasterFrame WorldRaster() const;
};

Result<SimulatedFlight> PlanSimulatedFlight(const SimulateOptions& options);
image::DecodedImage RenderSimulatedPhoto(const SimulatedFlight& flight, std::size_t index);

// Writes out_dir/photos/*.JPG (of a rig a TIFF for each band), out_dir/truth/poses.json,
// out_dir/truth/world.tif and, if asked for, out_dir/truth/surface.tif and out_dir/logs/*. Errors:
// kInvalidArgument, kIo, kCancelled.
Result<SimulatedFlight> SimulateFlight(const SimulateOptions& options, const std::filesystem::path& out_dir,
                                       Progress& progress);

// poses.json: the truth about every photo, for tests and for people.
std::string TruthJson(const SimulatedFlight& flight);

// RenderSimulatedPhoto, or what remembers what it made. Any thread.
using PictureOf = std::function<image::DecodedImage(const SimulatedFlight&, std::size_t index)>;

// Renders when asked, so any number of photos costs no memory. Looks photos up by name. Any thread.
class SimulatedPhotoSource final : public flight::PhotoSource {
 public:
  explicit SimulatedPhotoSource(const SimulatedFlight& flight);  // keeps a reference
  SimulatedPhotoSource(const SimulatedFlight& flight, PictureOf picture_of);
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override;

 private:
  const SimulatedFlight& flight_;
  PictureOf picture_of_;
  std::map<std::string, std::size_t> index_of_name_;
};

}  // namespace skyquilt::simulate
