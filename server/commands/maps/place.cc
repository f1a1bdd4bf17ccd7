#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/text/printable.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/flight/remarks/remark_words.h"
#include "server/commands/arguments.h"
#include "server/commands/commands.h"
#include "server/commands/maps/map_notes.h"
#include "server/jobs/out_folder.h"
#include "server/jobs/stitch_job.h"
#include "server/terminal/fail.h"
#include "server/terminal/terminal_progress.h"
#include "server/usage/option_values.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCommand = "skyquilt place";

struct PlaceArguments {
  fs::path map_dir;
  std::string origin;
  std::string scale;
  pipeline::PlaceRequest request;  // as far as options say it word for word
  std::vector<fs::path> gcp;
  std::vector<std::string> points;
  int threads = 0;
  double max_memory_gib = 1.0;
};

// "0.03" is metres a pixel, "2.5x" so many times larger.
void TakeScale(const std::string& text, pipeline::PlaceRequest& request) {
  if (text.empty()) return;
  const bool is_factor = text.ends_with('x');
  const std::string number = is_factor ? text.substr(0, text.size() - 1) : text;
  const bool has_unit = !number.empty() && std::isalpha(static_cast<unsigned char>(number.back())) != 0;
  const std::optional<double> value = ParseLengthM(number);
  if (!value || !(*value > 0.0) || (is_factor && has_unit)) {
    Refuse(
        kCommand,
        "--scale is '" + text +
            "'; write the ground that a photo's pixel shows in metres, like 0.03 or 3cm, or by how many times the map "
            "is to become larger, like 2.5x.");
  }
  (is_factor ? request.factor : request.photo_pixel_m) = *value;
}

geo::LatLon PlaceFrom(const char* option, const std::string& text) {
  const geo::LatLon place = ParseLatLon(kCommand, option, text);
  if (!(std::abs(place.lat_deg) <= 85.0 && std::abs(place.lon_deg) <= 180.0))
    Refuse(kCommand, std::string(option) + " is " + text +
                         " but must be a latitude up to 85 and a longitude up to 180 degrees.");
  return place;
}

// "47.1,7.2=47.3,7.4"
pipeline::ShownPair PairOf(const std::string& text) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos)
    Refuse(kCommand,
           "--point is '" + text +
               "'; write where the map shows a thing and where it is, like 0.0001,0.0002=46.80,7.10.");
  return {PlaceFrom("--point", text.substr(0, at)), PlaceFrom("--point", text.substr(at + 1))};
}

pipeline::PlaceRequest RequestOf(const PlaceArguments& arguments) {
  pipeline::PlaceRequest request = arguments.request;
  if (!arguments.origin.empty()) request.origin = PlaceFrom("--origin", arguments.origin);
  for (const std::string& text : arguments.points) request.pairs.push_back(PairOf(text));
  if (arguments.origin.empty() && arguments.gcp.empty() && arguments.points.empty())
    Refuse(kCommand, "Say where the map lies: --origin LAT,LON, --gcp gcp_list.txt or --point SHOWN=IS.");
  TakeScale(arguments.scale, request);
  for (const fs::path& path : arguments.gcp) {
    Result<flight::GcpList> list = flight::ReadGcpList({path.filename().string(), path});
    if (!list) {
      Error error = list.error();
      error.message = path.filename().string() + " cannot be read as surveyed points: " + error.message;
      Fail(kCommand, error);
    }
    for (const std::string& warning : flight::InWords(list->warnings))
      fmt::print(stderr, "Warning: {}\n", Printable(path.filename().string() + ": " + warning));
    request.control.push_back(*std::move(list));
  }
  return request;
}

// What was asked for when the map was made, and which files the folder has.
StitchJobOptions OptionsOf(const PlaceArguments& arguments) {
  StitchJobOptions options;
  // Its pixels go with it, and its photos lie above an elevation model as they do.
  OrFail(kCommand, TakeOptionsOfMap(arguments.map_dir, {"--gsd", "--dem"}, options.mosaic));
  const auto has = [&](const std::string& name) { return fs::exists(arguments.map_dir / name); };
  options.write_cog = has("mosaic.tif");
  options.write_pmtiles = has("mosaic.pmtiles");
  options.mosaic.write_utm = has("mosaic_utm.tif");
  options.write_kmz = has("mosaic.kmz");
  options.mosaic.heights = HeightsIn(arguments.map_dir);
  options.mosaic.threads = arguments.threads;
  options.mosaic.max_memory_bytes = static_cast<std::int64_t>(arguments.max_memory_gib * (1 << 30));
  const auto tiles = OrFail(kCommand, storage::MbtilesReader::Open(arguments.map_dir / "mosaic.mbtiles"));
  options.mosaic.encoding = storage::EncodingOf(tiles->metadata());
  return options;
}

void Run(const PlaceArguments& arguments) {
  const pipeline::PlaceRequest request = RequestOf(arguments);
  const FileDescriptor taken = OrFail(kCommand, TakeOutFolder(arguments.map_dir));
  const auto files = OrFail(kCommand, FilesOfMap(arguments.map_dir));
  for (const flight::InputFile& file : files) {
    if (fs::exists(file.path)) continue;
    Fail(kCommand,
         {ErrorCode::kNotFound,
          file.path.string() + " is gone; a map is drawn again when it is placed, which needs its photos "
                               "where they were."});
  }
  OrFail(kCommand, CheckListStays(arguments.map_dir));
  StitchJobOptions options = OptionsOf(arguments);
  options.mosaic.placing = request;
  const pipeline::MosaicReport report = OrFail(kCommand, [&] {
    TerminalProgress progress;
    return StitchToDirectory(files, options, arguments.map_dir, progress);
  }());
  PrintNotes(report);
  fmt::print("{}, {:.7f},{:.7f} to {:.7f},{:.7f} (LAT,LON)\n{}\n{}\n", SizeInWords(report),
             report.bounds.south_deg, report.bounds.west_deg, report.bounds.north_deg, report.bounds.east_deg,
             pipeline::QualityInWords(report.quality), (arguments.map_dir / "mosaic.mbtiles").string());
}

}  // namespace

void AddPlaceCommand(CLI::App& app) {
  const auto arguments = std::make_shared<PlaceArguments>();
  CLI::App* command = app.add_subcommand(
      "place", "Put a map that is not georeferenced where it belongs, without aligning its photos again");
  command
      ->add_option("MAP", arguments->map_dir,
                   "Folder that \"stitch\" wrote; its photos must be where they were")
      ->required()
      ->check(CLI::ExistingDirectory);
  CLI::Option* origin = command->add_option(
      "--origin", arguments->origin,
      "LAT,LON in degrees of the middle of the photos; of the take-off, where the map was reckoned from it; with "
      "--at of where that photo was taken");
  command
      ->add_option("--at", arguments->request.origin_photo, "Name of the photo that was taken above --origin")
      ->needs(origin);
  command
      ->add_option(
          "--scale", arguments->scale,
          "How large things are: ground that a photo's pixel shows in metres (0.03, or 3cm: the flying height "
          "divided by the focal length in pixels), or a factor (2.5x: all distances on the map are to "
          "become 2.5 times as long). Default: as the map is")
      ->needs(origin);
  command
      ->add_option(
          "--north", arguments->request.north_deg,
          "Which direction on the map as it is drawn now is north, in degrees clockwise from its top (90: "
          "what is right now will be up)")
      ->needs(origin);
  command
      ->add_option(
          "--gcp", arguments->gcp,
          "Instead of a place: surveyed points, in the format of gcp_list.txt (reference system, then rows "
          "x y z pixel_x pixel_y photo name). Three or more, spread over the map, each marked in two or "
          "more photos; they give place, scale, north and, where they have heights, the tilt")
      ->check(CLI::ExistingFile)
      ->excludes(origin);
  command
      ->add_option(
          "--point", arguments->points,
          "Instead of both: LAT,LON=LAT,LON, where the map shows a thing and where it really is; again for "
          "more of them. One shifts the map (also one that has its place), two or more turn and scale it "
          "too")
      ->excludes(origin)
      ->excludes("--gcp");
  command->add_flag("--again", arguments->request.is_again,
                    "Also a map that is georeferenced: what its records said of its place is overruled");
  command->add_option("--threads", arguments->threads, "Threads; 0 takes all cores")->capture_default_str();
  command->add_option("--max-memory", arguments->max_memory_gib, "Memory for photos and tiles in GiB")
      ->check(CLI::Range(0.25, 65536.0))
      ->capture_default_str();
  command->footer(
      "A map of photos without any position is whole, but lies at 0,0 with a guessed scale and north. What is known\n"
      "of its place can be said later; the map is then drawn again, and no photo is compared.\n"
      "Example:\n"
      "  skyquilt place map --gcp gcp_list.txt\n"
      "  skyquilt place map --origin 46.80,7.10 --scale 0.03 --north 12\n"
      "  skyquilt place map --point 0.0003,-0.0004=46.8012,7.1003 --point -0.0002,0.0005=46.8001,7.1021\n"
      "  skyquilt place map --origin 46.80,7.10 --at DJI_0007.JPG --again");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
