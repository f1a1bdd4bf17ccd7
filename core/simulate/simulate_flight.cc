#include "core/simulate/simulate_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <system_error>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "core/camera/footprint.h"
#include "core/geo/web_mercator.h"
#include "core/simulate/world/random.h"
#include "core/simulate/world/world_raster.h"
#include "core/simulate/writers/photo_tags.h"
#include "core/simulate/writers/write_logs.h"
#include "core/simulate/writers/write_photo.h"

namespace skyquilt::simulate {
namespace {

constexpr double kHighestLatDeg = 85.0;  // Web Mercator ends at 85.05

Error Bad(std::string message) {
  return Error{ErrorCode::kInvalidArgument, std::move(message), "simulate options"};
}

Result<void> MakeFolder(const std::filesystem::path& path) {
  std::error_code failure;
  std::filesystem::create_directories(path, failure);
  if (failure) {
    return Error{ErrorCode::kIo,
                 "Could not make the folder " + path.string() + ": " + failure.message() + ".",
                 "create_directories failed"};
  }
  return {};
}

// The mean of denominator x denominator pixels; what is left at the far sides is averaged among itself.
image::DecodedImage Shrunk(const image::DecodedImage& image, int denominator) {
  image::DecodedImage small;
  small.width_px = (image.width_px + denominator - 1) / denominator;
  small.height_px = (image.height_px + denominator - 1) / denominator;
  small.rgb.resize(static_cast<std::size_t>(small.width_px) * static_cast<std::size_t>(small.height_px) * 3);
  for (int y = 0; y < small.height_px; ++y) {
    const int y_end = std::min((y + 1) * denominator, image.height_px);
    for (int x = 0; x < small.width_px; ++x) {
      const int x_end = std::min((x + 1) * denominator, image.width_px);
      int sum[3] = {0, 0, 0};
      for (int yy = y * denominator; yy < y_end; ++yy) {
        for (int xx = x * denominator; xx < x_end; ++xx) {
          for (int c = 0; c < 3; ++c) sum[c] += image.Row(yy)[3 * xx + c];
        }
      }
      const int count = (y_end - y * denominator) * (x_end - x * denominator);
      std::uint8_t* out =
          small.rgb.data() + (static_cast<std::size_t>(y) * static_cast<std::size_t>(small.width_px) +
                              static_cast<std::size_t>(x)) *
                                 3;
      for (int c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>((sum[c] + count / 2) / count);
    }
  }
  return small;
}

Result<void> WriteLogs(const SimulatedFlight& flight, const std::filesystem::path& folder) {
  if (!flight.log || flight.options.log_formats.empty()) return {};
  SKYQUILT_TRY(MakeFolder(folder));
  for (const LogFormat format : flight.options.log_formats) {
    switch (format) {
      case LogFormat::kDataflash:
        SKYQUILT_TRY(WriteBytes(folder / "flight.BIN", DataflashBytes(*flight.log)));
        break;
      case LogFormat::kUlog:
        SKYQUILT_TRY(WriteBytes(folder / "flight.ulg", UlogBytes(*flight.log)));
        break;
      case LogFormat::kCsv: {
        const std::string text = FlightCsv(*flight.log);
        SKYQUILT_TRY(WriteBytes(folder / "flight.csv", {text.begin(), text.end()}));
        break;
      }
    }
  }
  return {};
}

constexpr double kLookedAtBeyond = 0.25;  // of the height of flight, beyond the outermost photos

geo::Bounds2 AreaLookedAt(const std::vector<TruePose>& poses, double flight_height_m) {
  geo::Bounds2 area;
  for (const TruePose& pose : poses) area.Include(pose.cam_from_enu.TargetOriginInSource().head<2>());
  const Eigen::Vector2d beyond = Eigen::Vector2d::Constant(kLookedAtBeyond * flight_height_m);
  return {area.min - beyond, area.max + beyond};
}

std::string BandFileName(std::size_t capture, std::size_t band) {
  return fmt::format("SIM_{:04}_{}.TIF", capture + 1, band + 1);
}

Result<void> WriteCapture(const SimulatedFlight& flight, std::size_t capture,
                          const std::filesystem::path& folder) {
  const SimulatedPhoto& photo = flight.photos[capture];
  const double noise_levels = 65536.0 / 256.0 * 0.1 * flight.options.noise_counts;  // less than of a JPEG
  for (std::size_t band = 0; band < flight.rig.size(); ++band) {
    const BandExposure exposure = ExposureOf(flight.rig[band], capture, flight.options.seed);
    const image::SampleImage picture =
        RenderBand(flight.world, flight.rig[band], photo.pose, exposure, noise_levels, 1);
    SKYQUILT_TRY(WriteBytes(folder / BandFileName(capture, band),
                            BandTiffBytes(photo.recorded, flight.rig[band], exposure, picture)));
  }
  return {};
}

constexpr double kStoredGamma = 2.2;  // a stored value to this power goes with the light, roughly
constexpr double kGyroNoiseRadps = 0.004;
constexpr double kGyroBiasRadps = 0.003;
constexpr double kFastestShakingRadps = 2.0;

void Shake(const SimulateOptions& options, std::size_t i, SimulatedPhoto& photo) {
  RandomStream random(HashCell(static_cast<std::int32_t>(i), 23, options.seed), 401);
  const Shaking shaking(options.shaking_radps, random);
  photo.render.readout_motion.turns_rad =
      shaking.TurnsOfRows(options.readout_s, photo.photo.exposure_time_s.value_or(0.0));
  if (!options.has_gyro) return;
  GyroModel gyro;
  if (options.noise != NoiseClass::kExact) gyro = {kGyroNoiseRadps, kGyroBiasRadps};
  photo.recorded.turning = RecordShaking(shaking, options.readout_s, gyro, random);
  photo.recorded.readout_s = options.readout_s;
  photo.photo.turning = photo.recorded.turning;
  photo.photo.readout_s = options.readout_s;
}

}  // namespace

Result<void> SimulateOptions::Validate() const {
  if (!(std::abs(origin.lat_deg) <= kHighestLatDeg) || !(std::abs(origin.lon_deg) <= 180.0)) {
    return Bad(fmt::format(
        "The simulated flight's position is {}, {}; the latitude must lie within 85 degrees of the "
        "equator and the longitude within 180.",
        origin.lat_deg, origin.lon_deg));
  }
  if (intrinsics.width_px < 16 || intrinsics.height_px < 16 || intrinsics.width_px > 20000 ||
      intrinsics.height_px > 20000) {
    return Bad(fmt::format("The photos' size is {} x {} pixels; each side must be from 16 to 20000.",
                           intrinsics.width_px, intrinsics.height_px));
  }
  if (!(intrinsics.focal_x_px > 0.1 * intrinsics.width_px &&
        intrinsics.focal_x_px < 100.0 * intrinsics.width_px)) {
    return Bad(fmt::format("The focal length is {} pixels; it must be from 0.1 to 100 image widths.",
                           intrinsics.focal_x_px));
  }
  const double x = 0.5 * intrinsics.width_px / intrinsics.focal_x_px;
  const double y = 0.5 * intrinsics.height_px / intrinsics.focal_y_px;
  const Eigen::Vector2d corner = intrinsics.Undistort({x, y});
  if (intrinsics.HasDistortion() && !(corner.squaredNorm() < intrinsics.MaxRadiusSquared() &&
                                      (intrinsics.Distort(corner) - Eigen::Vector2d(x, y)).norm() < 1e-6)) {
    return Bad("The lens distortion folds the image's corners back: make k1 and k2 smaller.");
  }
  if (!(vignetting >= 0.0 && vignetting < 1.0))
    return Bad("The vignetting must be from 0 to 1 (share of light lost).");
  if (!(hot_spot >= 0.0 && hot_spot < 1.0))
    return Bad("The hot spot must be from 0 to 1 (share of light added).");
  if (!(hot_spot_rad >= 0.005 && hot_spot_rad <= 1.0))
    return Bad("The hot spot's width must be from 0.3 to 57 degrees.");
  if (!(std::abs(world.gradient_per_km) <= 2.0)) return Bad("The gradient must be within 2 a kilometre.");
  if (!(exposure_jitter >= 0.0 && exposure_jitter < 1.0))
    return Bad("The exposure jitter must be from 0 to 1.");
  if (!(shutter_s >= 0.0 && shutter_s <= 10.0)) return Bad("The exposure time must be from 0 to 10000 ms.");
  if (!(readout_s >= 0.0 && readout_s <= 0.5)) return Bad("The readout time must be from 0 to 500 ms.");
  if (!(shaking_radps >= 0.0 && shaking_radps <= kFastestShakingRadps))
    return Bad("The shaking must be from 0 to 114 degrees per second.");
  if (has_gyro && !(readout_s > 0.0 && shaking_radps > 0.0))
    return Bad("A gyro is recorded of a camera that shakes while it reads its rows: give both times.");
  if (has_band_rig &&
      (vignetting > 0.0 || exposure_jitter > 0.0 || hot_spot > 0.0 || shutter_s > 0.0 || readout_s > 0.0))
    return Bad(
        "A rig of bands has vignetting and exposures of its own: leave out those of the photos, and shutters.");
  if (jpeg_quality < 1 || jpeg_quality > 100) return Bad("The JPEG quality must be from 1 to 100.");
  if (!(std::abs(world.relief_m) <= 0.4 * trajectory.height_m)) {
    return Bad(
        fmt::format("Hills of {} m reach too near to a flight at {} m; take at most 0.4 of the height.",
                    world.relief_m, trajectory.height_m));
  }
  if (!log_formats.empty() && !survey)
    return Bad("A log can be written only of a flight that is flown (survey).");
  if (world.has_boxes && trajectory.height_m < 15.0)
    return Bad("A flight over buildings must be at least 15 m high.");
  if (world.has_boxes && world.objects.Count() > 0)
    return Bad("Houses, walls and trees stand in a world without boxes: leave out one or the other.");
  SKYQUILT_TRY(world.objects.Validate(trajectory.height_m));
  return trajectory.Validate();
}

geo::RasterFrame SimulatedFlight::WorldRaster() const {
  geo::Bounds2 bounds;
  for (const SimulatedPhoto& photo : photos) {
    for (const Eigen::Vector2d& corner :
         camera::GroundFootprint(options.intrinsics, photo.pose.cam_from_enu, 0.0)) {
      const geo::Wgs84 at = frame.Wgs84FromEnu({corner.x(), corner.y(), 0.0});
      const double origin_lon_deg = frame.origin().lon_deg;
      // On the origin's side of the antimeridian, also where it lies across.
      bounds.Include(geo::MercFromLatLon(
          {at.lat_deg, origin_lon_deg + std::remainder(at.lon_deg - origin_lon_deg, 360.0)}));
    }
  }
  int zoom = geo::ZoomForGsd(GsdM(), frame.origin().lat_deg, kWorldTilePx);
  geo::RasterFrame raster = WorldRasterFrame(bounds, zoom);
  while (zoom > 0 && 1e-6 * raster.width_px * raster.height_px > options.largest_world_megapixels) {
    raster = WorldRasterFrame(bounds, --zoom);
  }
  return raster;
}

Result<SimulatedFlight> PlanSimulatedFlight(const SimulateOptions& options) {
  SKYQUILT_TRY(options.Validate());
  SimulatedFlight flight;
  flight.options = options;
  flight.options.trajectory.seed = options.seed;
  flight.frame =
      geo::LocalFrame({options.origin.lat_deg, options.origin.lon_deg, options.takeoff_height_ellipsoid_m});
  Result<std::vector<TruePose>> poses = [&]() -> Result<std::vector<TruePose>> {
    if (!options.survey) return PlanLawnmower(flight.options.trajectory, options.intrinsics);
    SurveyOptions survey = *options.survey;
    survey.plan = flight.options.trajectory;
    SKYQUILT_TRY_ASSIGN(auto flown, FlySurvey(survey, options.intrinsics, flight.frame, options.start));
    flight.log = std::move(flown.log);
    return std::move(flown.poses);
  }();
  if (!poses) return poses.error();
  if (options.world.objects.Count() > 0) {
    const geo::Bounds2 area = AreaLookedAt(*poses, options.trajectory.height_m);
    flight.options.world.objects.area_min = area.min;
    flight.options.world.objects.area_max = area.max;
  }
  flight.world = World(flight.options.world);
  const std::vector<RecordedPose> recorded = RecordPoses(
      *poses, flight.frame, options.intrinsics, options.start, options.noise, options.clock, options.seed);
  if (options.has_band_rig) flight.rig = MakeBandRig(options.intrinsics, options.seed);
  RandomStream exposure(options.seed, 301);
  for (std::size_t i = 0; i < poses->size(); ++i) {
    SimulatedPhoto photo;
    photo.pose = (*poses)[i];
    photo.recorded = recorded[i];
    photo.render.exposure_gain = std::exp(options.exposure_jitter * exposure.Gauss());
    if (options.is_exposure_recorded) {
      photo.recorded.exposure_time_s *= std::pow(photo.render.exposure_gain, kStoredGamma);
    }
    photo.photo = PhotoOfRecordedPose(
        options.has_band_rig ? BandFileName(i, kReferenceBand) : fmt::format("SIM_{:04}.JPG", i + 1),
        photo.recorded);
    photo.render.vignetting = options.vignetting;
    photo.render.hot_spot = options.hot_spot;
    photo.render.hot_spot_rad = options.hot_spot_rad;
    photo.render.sun_in_enu = SunDirection(options.origin, options.start);
    photo.render.motion_in_enu_m = options.shutter_s * photo.pose.velocity_in_enu_mps;
    photo.render.readout_motion.shift_in_enu_m = options.readout_s * photo.pose.velocity_in_enu_mps;
    if (options.readout_s > 0.0 && options.shaking_radps > 0.0) Shake(options, i, photo);
    photo.render.noise_counts = options.noise_counts;
    photo.render.noise_seed = HashCell(static_cast<std::int32_t>(i), 17, options.seed);
    flight.photos.push_back(std::move(photo));
  }
  return flight;
}

image::DecodedImage RenderSimulatedPhoto(const SimulatedFlight& flight, std::size_t index) {
  const SimulatedPhoto& photo = flight.photos.at(index);
  return RenderPhoto(flight.world, flight.options.intrinsics, photo.pose.cam_from_enu, photo.render);
}

Result<SimulatedFlight> SimulateFlight(const SimulateOptions& options, const std::filesystem::path& out_dir,
                                       Progress& progress) {
  SKYQUILT_TRY_ASSIGN(SimulatedFlight flight, PlanSimulatedFlight(options));
  SKYQUILT_TRY(MakeFolder(out_dir / "photos"));
  SKYQUILT_TRY(MakeFolder(out_dir / "truth"));

  progress.BeginStage("photos");
  std::mutex mutex;
  std::optional<Error> failure;
  std::atomic<std::size_t> done = 0;
  for (SimulatedPhoto& photo : flight.photos) photo.photo.path = out_dir / "photos" / photo.photo.name;
  ParallelFor(flight.photos.size(), options.threads, [&](std::size_t i) {
    if (progress.IsCancelled()) return;
    const SimulatedPhoto& photo = flight.photos[i];
    const Result<void> written =
        flight.rig.empty() ? WriteBytes(photo.photo.path, EncodePhoto(RenderSimulatedPhoto(flight, i),
                                                                      photo.recorded, options.jpeg_quality))
                           : WriteCapture(flight, i, out_dir / "photos");
    const std::lock_guard lock(mutex);
    if (!written && !failure) failure = written.error();
    progress.Report(static_cast<double>(++done) / static_cast<double>(flight.photos.size()),
                    fmt::format("{} of {} photos", done.load(), flight.photos.size()));
  });
  if (failure) return *failure;
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The simulation was cancelled.", ""};

  const std::string truth = TruthJson(flight);
  SKYQUILT_TRY(WriteBytes(out_dir / "truth" / "poses.json", {truth.begin(), truth.end()}));
  SKYQUILT_TRY(WriteLogs(flight, out_dir / "logs"));
  if (options.write_world) {
    progress.BeginStage("truth");
    SKYQUILT_TRY(WriteWorldGeoTiff(flight.world, flight.frame, flight.WorldRaster(), options.threads,
                                   out_dir / "truth" / "world.tif", progress));
  }
  if (options.write_surface) {
    progress.BeginStage("truth");
    SKYQUILT_TRY(WriteSurfaceGeoTiff(flight.world, flight.frame, flight.WorldRaster(), options.threads,
                                     out_dir / "truth" / "surface.tif", progress));
  }
  return flight;
}

SimulatedPhotoSource::SimulatedPhotoSource(const SimulatedFlight& flight)
    : SimulatedPhotoSource(flight, [](const SimulatedFlight& of, std::size_t index) {
        return RenderSimulatedPhoto(of, index);
      }) {}

SimulatedPhotoSource::SimulatedPhotoSource(const SimulatedFlight& flight, PictureOf picture_of)
    : flight_(flight), picture_of_(std::move(picture_of)) {
  for (std::size_t i = 0; i < flight.photos.size(); ++i) index_of_name_[flight.photos[i].photo.name] = i;
}

Result<image::DecodedImage> SimulatedPhotoSource::Decode(const flight::Photo& photo, int denominator) const {
  const auto found = index_of_name_.find(photo.name);
  if (found == index_of_name_.end()) {
    return Error{ErrorCode::kNotFound, "The simulated flight has no photo named " + photo.name + ".", ""};
  }
  const image::DecodedImage image = picture_of_(flight_, found->second);
  return denominator == 1 ? image : Shrunk(image, denominator);
}

}  // namespace skyquilt::simulate
