#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/text/printable.h"
#include "core/simulate/simulate_flight.h"
#include "server/commands/commands.h"
#include "server/terminal/fail.h"
#include "server/terminal/terminal_progress.h"
#include "server/usage/option_values.h"

namespace skyquilt::server {
namespace {

using simulate::CameraMount;
using simulate::LogFormat;
using simulate::NoiseClass;
using simulate::TextureLevel;
using simulate::YawRule;

enum class ImuKind { kNone, kIcm, kMpu, kRough };

struct SimulateArguments {
  std::filesystem::path out_dir;
  simulate::SimulateOptions options;
  std::string size = "1600x1200";
  std::vector<double> distortion;
  double focal_px = 0.0;
  double heading_deg = 0.0;
  double tilt_deg = 0.0;
  double yaw_wander_deg = 0.0;
  double hot_spot_deg = 11.5;
  double shutter_ms = 0.0;
  double readout_ms = 0.0;
  double shaking_dps = 0.0;
  bool no_world = false;
  std::vector<double> house_heights_m;
  simulate::SurveyOptions survey;
  ImuKind imu = ImuKind::kIcm;
  bool rtk_log = false;
  bool no_gnss_log = false;
};

camera::Intrinsics LensOf(const SimulateArguments& arguments) {
  int width = 0;
  int height = 0;
  char rest = 0;
  if (std::sscanf(arguments.size.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width <= 0 ||
      height <= 0) {
    Refuse("skyquilt", "--size is '" + arguments.size + "'; write it as WIDTHxHEIGHT, like 4000x3000.");
  }
  // A common drone lens sees 67 degrees across unless another field of view is given.
  const double focal_px = arguments.focal_px > 0.0 ? arguments.focal_px : 0.75 * width;
  camera::Intrinsics lens = camera::Intrinsics::Centered(width, height, focal_px);
  if (arguments.distortion.size() == 4) {
    lens.k1 = arguments.distortion[0];
    lens.k2 = arguments.distortion[1];
    lens.p1 = arguments.distortion[2];
    lens.p2 = arguments.distortion[3];
  }
  return lens;
}

// The aircraft and its recorder, when a log is requested.
simulate::SurveyOptions SurveyOf(const SimulateArguments& arguments) {
  simulate::SurveyOptions survey = arguments.survey;
  survey.sensors.has_imu = arguments.imu != ImuKind::kNone;
  if (arguments.imu == ImuKind::kMpu) survey.sensors.imu = simulate::MpuClassImu();
  if (arguments.imu == ImuKind::kRough)
    survey.sensors.imu = simulate::WithDefects(simulate::IcmClassImu(), 1.0);
  if (arguments.rtk_log) survey.sensors.gnss = simulate::RtkGnss();
  survey.sensors.has_gnss = !arguments.no_gnss_log;
  return survey;
}

void PrintObjects(const simulate::ObjectOptions& wanted, const simulate::World& world) {
  int houses = 0, walls = 0, trees = 0;
  for (const simulate::StandingObject& object : world.objects())
    ++(object.IsHouse() ? houses : object.kind == simulate::ObjectKind::kWall ? walls : trees);
  fmt::print("{}, {} and {} stand on the ground{}\n", Counted(houses, "house"), Counted(walls, "wall"),
             Counted(trees, "tree"),
             houses + walls + trees < wanted.Count() ? "; there is no room for more" : "");
}

void Run(SimulateArguments& arguments) {
  simulate::SimulateOptions& options = arguments.options;
  if (!options.log_formats.empty()) options.survey = SurveyOf(arguments);
  options.intrinsics = LensOf(arguments);
  options.trajectory.heading_rad = geo::DegToRad(arguments.heading_deg);
  options.trajectory.max_tilt_rad = geo::DegToRad(arguments.tilt_deg);
  options.trajectory.yaw_wander_rad = geo::DegToRad(arguments.yaw_wander_deg);
  options.hot_spot_rad = geo::DegToRad(arguments.hot_spot_deg);
  options.shutter_s = 1e-3 * arguments.shutter_ms;
  options.readout_s = 1e-3 * arguments.readout_ms;
  options.shaking_radps = geo::DegToRad(arguments.shaking_dps);
  options.write_world = !arguments.no_world;
  options.world.seed = options.seed;
  if (arguments.house_heights_m.size() == 2) {
    options.world.objects.lowest_house_m = arguments.house_heights_m[0];
    options.world.objects.highest_house_m = arguments.house_heights_m[1];
  }
  const simulate::SimulatedFlight flight = OrFail("skyquilt", [&] {
    TerminalProgress progress;
    return simulate::SimulateFlight(options, arguments.out_dir, progress);
  }());
  fmt::print("{} of {} x {} pixels, {:.2f} cm a pixel on the ground\n",
             Counted(flight.photos.size(), "photo"), options.intrinsics.width_px,
             options.intrinsics.height_px, 100.0 * flight.GsdM());
  if (options.world.objects.Count() > 0) PrintObjects(options.world.objects, flight.world);
  fmt::print("{}\n{}\n", (arguments.out_dir / "photos").string(), (arguments.out_dir / "truth").string());
}

// A value whose help says what it is by itself.
template <typename Value>
CLI::Option* AddValue(CLI::App& command, const char* name, Value& value, const char* help) {
  return command.add_option(name, value, help)->capture_default_str();
}

// What stands on the ground.
void AddObjectOptions(CLI::App& command, SimulateArguments& arguments) {
  simulate::ObjectOptions& objects = arguments.options.world.objects;
  AddValue(command, "--houses", objects.houses,
           "Houses of 8 to 20 m a side with flat and gabled roofs, turned any way, where the photos look; "
           "truth/poses.json has the corners and heights of all that stands");
  command
      .add_option("--house-heights-m", arguments.house_heights_m,
                  "With --houses: how high the lowest and the highest may be, in metres (default: 3 12)")
      ->needs("--houses")
      ->expected(2);
  AddValue(command, "--walls", objects.walls, "Garden walls of 1.5 to 3 m");
  AddValue(command, "--trees", objects.trees, "Trees of 3 to 10 m");
  command.add_flag("--surface", arguments.options.write_surface,
                   "Also write truth/surface.tif: the true heights over the ellipsoid, with and without what "
                   "stands on the ground");
}

// What the recorder of the aircraft writes; without --log nothing is recorded.
void AddRecorderOptions(CLI::App& command, SimulateArguments& arguments) {
  simulate::SimulateOptions& options = arguments.options;
  CLI::Option* recorder =
      command
          .add_option(
              "--log", options.log_formats,
              "Fly it with a recorder and write logs/: dataflash (ArduPilot), ulog (PX4), csv; several "
              "may be named. "
              "The photos are then taken where the aircraft really was, leaning as it leans")
          ->transform(OneOf(std::vector<std::pair<std::string, LogFormat>>{
              {"dataflash", LogFormat::kDataflash}, {"ulog", LogFormat::kUlog}, {"csv", LogFormat::kCsv}}));
  command
      .add_option("--mount", arguments.survey.mount,
                  "With --log: fixed: the camera leans with the body; gimbal: it does not")
      ->needs(recorder)
      ->transform(OneOf(std::vector<std::pair<std::string, CameraMount>>{{"fixed", CameraMount::kFixedToBody},
                                                                         {"gimbal", CameraMount::kGimbal}}));
  command
      .add_option("--imu", arguments.imu,
                  "With --log: icm or mpu class; rough: with vibration, lost samples, scale errors; none")
      ->needs(recorder)
      ->transform(OneOf(std::vector<std::pair<std::string, ImuKind>>{{"none", ImuKind::kNone},
                                                                     {"icm", ImuKind::kIcm},
                                                                     {"mpu", ImuKind::kMpu},
                                                                     {"rough", ImuKind::kRough}}));
  command.add_flag("--log-rtk", arguments.rtk_log, "With --log: the recorder's GNSS is RTK")->needs(recorder);
  command.add_flag("--log-without-gnss", arguments.no_gnss_log, "With --log: the recorder has no GNSS")
      ->needs(recorder);
  command
      .add_flag("--log-range", arguments.survey.sensors.has_range,
                "With --log: a range finder that reaches 25 m")
      ->needs(recorder);
  AddValue(command, "--clock-offset-s", options.clock.offset_s, "How far the camera's clock is ahead of UTC");
  command.add_flag("--clock-seconds", options.clock.is_local_seconds,
                   "The camera's clock shows whole seconds of an unknown zone, as most do");
}

}  // namespace

void AddSimulateCommand(CLI::App& app) {
  auto arguments = std::make_shared<SimulateArguments>();
  simulate::SimulateOptions& options = arguments->options;
  CLI::App* command =
      app.add_subcommand("simulate", "Make a drone flight with known truth, to try Skyquilt and to test it");
  command
      ->add_option("-o,--out", arguments->out_dir,
                   "Folder for photos/ and truth/ (poses.json, world.tif); made if missing")
      ->required();
  AddValue(*command, "--photos", options.trajectory.photos, "Number of photos");
  AddValue(*command, "--lat", options.origin.lat_deg,
           "Latitude of take-off, the middle of the flight, in degrees");
  AddValue(*command, "--lon", options.origin.lon_deg, "Longitude of take-off in degrees");
  AddValue(*command, "--height", options.trajectory.height_m, "Height of flight above take-off in metres");
  AddValue(*command, "--overlap", options.trajectory.front_overlap,
           "Overlap of a photo with the next one along the line, 0 to 0.98 (0.75 is usual)");
  AddValue(*command, "--sidelap", options.trajectory.side_overlap,
           "Overlap with the neighbouring line, 0 to 0.98");
  AddValue(*command, "--heading", arguments->heading_deg,
           "Direction of the first line, degrees clockwise from north");
  AddValue(*command, "--speed", options.trajectory.speed_mps, "Speed in m/s: the time between photos");
  AddValue(*command, "--tilt-deg", arguments->tilt_deg,
           "Every photo leans by up to this many degrees, any way, as from a camera without gimbal");
  command
      ->add_option("--yaw", options.trajectory.yaw_rule,
                   "course: the image's top points ahead; fixed: always along the first line; any: at random")
      ->transform(OneOf(std::vector<std::pair<std::string, YawRule>>{
          {"course", YawRule::kAlongCourse}, {"fixed", YawRule::kFixed}, {"any", YawRule::kAnywhere}}));
  AddValue(*command, "--yaw-wander-deg", arguments->yaw_wander_deg,
           "How far the true yaw strays from that, 1-sigma");
  AddValue(*command, "--jitter-m", options.trajectory.position_jitter_m,
           "How far the true positions stray from the plan, 1-sigma in metres");
  AddValue(*command, "--height-wander-m", options.trajectory.height_wander_m,
           "How far the true height strays, 1-sigma");
  AddValue(*command, "--relief-m", options.world.relief_m,
           "Height of smooth hills in metres; 0 is flat ground");
  command->add_flag("--boxes", options.world.has_boxes,
                    "Buildings stand up instead of being painted on the ground");
  AddObjectOptions(*command, *arguments);
  command
      ->add_option(
          "--texture", options.world.texture,
          "rich: fields, roads, farms; rows: crop rows everywhere (repetitive); bare: sand (little to match)")
      ->transform(OneOf(std::vector<std::pair<std::string, TextureLevel>>{
          {"rich", TextureLevel::kRich}, {"rows", TextureLevel::kRows}, {"bare", TextureLevel::kBare}}));
  AddValue(*command, "--marks-m", options.world.mark_spacing_m,
           "Survey marks on the ground every so many metres; 0 is none");
  AddValue(*command, "--size", arguments->size, "Size of the photos in pixels");
  command->add_option("--focal-px", arguments->focal_px,
                      "Focal length in pixels (default: 0.75 of the width)");
  command->add_option("--distortion", arguments->distortion, "Lens distortion k1 k2 p1 p2, as OpenCV has it")
      ->expected(4);
  command
      ->add_option(
          "--noise", options.noise,
          "What the aircraft recorded: exact: the truth; xmp: a consumer drone (1.5 m, 0.6 deg tilt, 1.5 deg "
          "yaw, 1% focal length); rtk: 2 cm; no-attitude; no-gps; no-pose")
      ->transform(
          OneOf(std::vector<std::pair<std::string, NoiseClass>>{{"exact", NoiseClass::kExact},
                                                                {"xmp", NoiseClass::kXmpTypical},
                                                                {"rtk", NoiseClass::kRtk},
                                                                {"no-attitude", NoiseClass::kNoAttitude},
                                                                {"no-gps", NoiseClass::kNoGps},
                                                                {"no-pose", NoiseClass::kNoPose}}));
  AddRecorderOptions(*command, *arguments);
  AddValue(*command, "--exposure-jitter", options.exposure_jitter,
           "Brightness differs from photo to photo, 1-sigma (0.1 is 10%)");
  command
      ->add_flag("--exposure-recorded", options.is_exposure_recorded,
                 "With --exposure-jitter: the exposure times in the photos say so, as a camera's do")
      ->needs("--exposure-jitter");
  AddValue(*command, "--vignetting", options.vignetting, "Share of light lost in the corners");
  AddValue(*command, "--hot-spot", options.hot_spot,
           "Share by which ground looks brighter with the sun right behind the camera");
  AddValue(*command, "--hot-spot-deg", arguments->hot_spot_deg,
           "With --hot-spot: how far from there it is half of that, in degrees")
      ->needs("--hot-spot");
  AddValue(*command, "--gradient-per-km", options.world.gradient_per_km,
           "How much brighter the ground itself becomes to the east, as a logarithm");
  AddValue(*command, "--shutter-ms", arguments->shutter_ms,
           "Exposure time in milliseconds; blurs by speed x time");
  AddValue(*command, "--readout-ms", arguments->readout_ms,
           "Milliseconds from reading a picture's first row to its last, while the camera flies on");
  AddValue(*command, "--shaking-dps", arguments->shaking_dps,
           "With --readout-ms: the camera turns meanwhile, 1-sigma in degrees per second about each axis")
      ->needs("--readout-ms");
  command
      ->add_flag("--gyro", options.has_gyro,
                 "With --shaking-dps: the photos record the camera's gyro and its readout time")
      ->needs("--shaking-dps");
  command->add_flag(
      "--bands", options.has_band_rig,
      "A camera of five bands in place of one in colours: a TIFF for each, as MicaSense writes them, "
      "with lenses that stand apart, vignetting, exposure and light of each band's own");
  AddValue(*command, "--pixel-noise", options.noise_counts, "Sensor noise in 8-bit counts, 1-sigma");
  AddValue(*command, "--seed", options.seed,
           "Another number, another world and flight; the same number, the same bytes");
  command->add_flag("--no-world", arguments->no_world, "Skip truth/world.tif, which can be large");
  AddValue(*command, "--threads", options.threads,
           "Threads; 0 takes all cores. The bytes are the same with any number");
  command->footer(
      "Example:\n  skyquilt simulate -o demo --photos 30 --height 60\n  skyquilt stitch demo/photos -o map");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
