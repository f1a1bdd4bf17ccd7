#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/base/digest.h"
#include "core/base/text/printable.h"
#include "core/base/trace.h"
#include "core/flight/aside/aside.h"
#include "core/flight/remarks/remark_words.h"
#include "core/pipeline/report/ground_choice.h"
#include "server/commands/arguments.h"
#include "server/commands/commands.h"
#include "server/commands/maps/map_notes.h"
#include "server/jobs/out_folder.h"
#include "server/jobs/stitch_job.h"
#include "server/terminal/fail.h"
#include "server/terminal/terminal_progress.h"
#include "server/usage/job_option_flag.h"
#include "server/usage/option_values.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

// Of the map, beside mosaic.mbtiles.
enum class OtherFormat : std::uint8_t { kGeotiff, kPmtiles, kUtm, kKmz, kDsm, kDtm };

struct StitchArguments {
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path out_dir;
  StitchJobOptions job;
  double max_memory_gib = 1.0;
  std::string origin;
  std::filesystem::path boundary;
  std::vector<OtherFormat> formats;
  bool no_cog = false;
  bool no_pmtiles = false;
  bool utm = false;
  bool kmz = false;
  std::set<std::string> said;  // "--quality"
  bool append = false;
  bool overwrite = false;
  std::filesystem::path trace;
};

// As a shell takes it for one word.
std::string ShellWord(const std::filesystem::path& path) {
  std::string text = path.string();
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("._-/+,:@%").find(static_cast<char>(c)) != std::string_view::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), is_plain)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

void PrintNextSteps(const std::filesystem::path& out_dir) {
  const auto word = [&](const char* name) { return Printable(ShellWord(out_dir / name)); };
  const std::string map = Printable(ShellWord(out_dir));
  fmt::print(
      "What next:\n"
      "  skyquilt report {} -o {}\n"
      "  skyquilt export {} -o {} --crs utm\n"
      "  skyquilt import {} --data maps && skyquilt serve --data maps\n",
      map, word("report.html"), map, word("utm.tif"), word("mosaic.mbtiles"));
}

void PrintOutcome(const pipeline::MosaicReport& report, const std::filesystem::path& out_dir,
                  bool writes_dsm) {
  fmt::print("{}: {} aligned, {} by pose alone, {} left out\n", Counted(report.photos_total, "photo"),
             report.photos_aligned, report.photos_pose_only, report.photos_left_out);
  for (const std::string& line : flight::LeftOutInLines(report.left_out_photos))
    fmt::print("  left out: {}\n", Printable(line));
  PrintNotes(report);
  fmt::print("{}, zoom {} to {}, {} tiles\n{}\n", SizeInWords(report), report.min_zoom, report.max_zoom,
             report.tile_count, pipeline::QualityInWords(report.quality));
  if (report.ground_choice) {
    fmt::print(
        "--surface auto: {}; as first placed, {:.0f} % of what ties photos leaned by more than two pixels, three photos saw {:.0f} % of the ground\n",
        pipeline::IsUpright(*report.ground_choice) ? "upright" : "the smooth ground",
        report.ground_choice->leaning_share * 100.0, report.ground_choice->seen_share * 100.0);
  }
  if (report.surface) {
    const bool is_size_known = !report.quality.IsLimitedBy(pipeline::LimitKind::kScaleGuessed);
    const std::string cells =
        is_size_known ? fmt::format("of {:.1f} cm", report.surface->cell_m * 100.0) : "of unknown size";
    const char* const zero =
        writes_dsm && pipeline::CountsAsSurvey(report) ? ", counted as the surveyed points' are" : "";
    fmt::print("{} of cells {}, {:.0f} % measured{}\n",
               writes_dsm ? "dsm.tif: heights" : "upright by heights", cells,
               report.surface->measured_share * 100.0, zero);
    if (report.surface->contour_interval_m) {
      fmt::print("dtm.tif: the ground below; contours.gpkg, .geojson, .dxf: {}\n",
                 is_size_known ? fmt::format("a line every {} m", *report.surface->contour_interval_m)
                               : "of heights in unknown units");
    }
  }
  fmt::print("{}\n", (out_dir / "mosaic.mbtiles").string());
  PrintNextSteps(out_dir);
}

// The files of the finished map, then the others; one that is given again counts once.
void AddFinishedFiles(const std::filesystem::path& out_dir, std::vector<flight::InputFile>& files) {
  auto all = OrFail("skyquilt", FilesOfMap(out_dir));
  std::map<std::string, std::filesystem::path> finished;
  for (const flight::InputFile& file : all) {
    finished[file.name] = file.path;
    if (std::filesystem::exists(file.path)) continue;
    Fail("skyquilt",
         {ErrorCode::kNotFound,
          file.path.string() + " is gone; a map can only be added to where its photos still are"});
  }
  OrFail("skyquilt", CheckPhotosStay(out_dir, all));
  std::size_t given_again = 0;
  for (flight::InputFile& file : files) {
    const auto same = finished.find(file.name);
    if (same == finished.end()) {
      all.push_back(std::move(file));
      continue;
    }
    const Result<Digest> was = DigestOfFile(same->second), is = DigestOfFile(file.path);
    if (!was || !is || *was != *is) {
      Fail("skyquilt",
           {ErrorCode::kConflict,
            file.path.string() + " has the name of a file of the finished map and other content; rename it"});
    }
    ++given_again;
  }
  if (given_again > 0) fmt::print("{} in the map already\n", Counted(given_again, "file"));
  files = std::move(all);
}

// Before hours of work, not after them.
void CheckTraceCanBeWritten(const std::filesystem::path& trace) {
  std::error_code error;
  if (std::filesystem::is_directory(trace, error)) {
    Refuse("skyquilt", trace.string() + " is a folder; give --trace the name of a file");
  }
  std::string probe = trace.string() + ".XXXXXX";
  const int file = mkstemp(probe.data());
  if (file < 0) {
    Fail("skyquilt",
         {ErrorCode::kIo,
          fmt::format("{} cannot be written ({}); give --trace a file in a folder that is there and yours",
                      trace.string(), std::generic_category().message(errno))});
  }
  close(file);
  unlink(probe.c_str());
}

void Run(StitchArguments& arguments) {
  if (!arguments.origin.empty())
    arguments.job.mosaic.origin = ParseLatLon("skyquilt", "--origin", arguments.origin);
  if (!arguments.boundary.empty())
    arguments.job.mosaic.boundary = ReadBoundary("skyquilt", arguments.boundary);
  arguments.job.mosaic.max_memory_bytes = static_cast<std::int64_t>(arguments.max_memory_gib * (1 << 30));
  // What a map in this folder was written as before is written again, so that no file there shows another
  // map.
  const auto is_asked = [&](OtherFormat format) {
    const auto& asked = arguments.formats;
    return std::find(asked.begin(), asked.end(), format) != asked.end();
  };
  if (arguments.no_cog && is_asked(OtherFormat::kGeotiff))
    Refuse("skyquilt", "--formats geotiff asks for mosaic.tif, and --no-cog for none.");
  if (arguments.no_pmtiles && is_asked(OtherFormat::kPmtiles))
    Refuse("skyquilt", "--formats pmtiles asks for mosaic.pmtiles, and --no-pmtiles for none.");
  const auto is_wanted = [&](OtherFormat format, const char* name) {
    std::error_code none;
    return is_asked(format) || std::filesystem::exists(arguments.out_dir / name, none);
  };
  arguments.job.write_cog = !arguments.no_cog && is_wanted(OtherFormat::kGeotiff, "mosaic.tif");
  arguments.job.write_pmtiles = !arguments.no_pmtiles && is_wanted(OtherFormat::kPmtiles, "mosaic.pmtiles");
  arguments.job.mosaic.write_utm = arguments.utm || is_wanted(OtherFormat::kUtm, "mosaic_utm.tif");
  const pipeline::MapHeights asked_heights = is_asked(OtherFormat::kDtm)   ? pipeline::MapHeights::kGround
                                             : is_asked(OtherFormat::kDsm) ? pipeline::MapHeights::kSurface
                                                                           : pipeline::MapHeights::kNone;
  arguments.job.mosaic.heights = std::max(asked_heights, HeightsIn(arguments.out_dir));
  arguments.job.write_kmz = arguments.kmz || is_wanted(OtherFormat::kKmz, "mosaic.kmz");
  if (const Result<void> possible = arguments.job.mosaic.Validate(); !possible)
    Fail("skyquilt", possible.error());
  auto files = OrFail("skyquilt", FilesOfFlight(arguments.inputs));
  std::error_code unmade;  // the map says why
  if (!arguments.append) std::filesystem::create_directories(arguments.out_dir, unmade);
  const FileDescriptor taken = OrFail("skyquilt", TakeOutFolder(arguments.out_dir));
  if (arguments.append) {
    OrFail("skyquilt", CheckListStays(arguments.out_dir));
    AddFinishedFiles(arguments.out_dir, files);
    OrFail("skyquilt", TakeOptionsOfMap(arguments.out_dir, arguments.said, arguments.job.mosaic));
  } else if (arguments.overwrite) {
    OrFail("skyquilt", CheckNoInputIsReplaced(arguments.out_dir, files));
  } else {
    OrFail("skyquilt", CheckOutFolder(arguments.out_dir, files, arguments.job.mosaic));
  }
  if (arguments.job.mosaic.title.empty()) arguments.job.mosaic.title = NameOfInput(arguments.inputs.front());
  if (!arguments.trace.empty()) {
    CheckTraceCanBeWritten(arguments.trace);
    BeginTrace();
  }
  Result<pipeline::MosaicReport> report = [&] {
    TerminalProgress progress;
    return StitchToDirectory(files, arguments.job, arguments.out_dir, progress);
  }();
  if (!arguments.trace.empty()) {
    OrFail("skyquilt", storage::WriteFileAtomically(arguments.trace, EndTrace()));
  }
  if (!report) Fail("skyquilt", report.error());
  PrintOutcome(*report, arguments.out_dir, arguments.job.mosaic.heights != pipeline::MapHeights::kNone);
}

}  // namespace

void AddStitchCommand(CLI::App& app) {
  auto arguments = std::make_shared<StitchArguments>();
  CLI::App* command = app.add_subcommand("stitch", "Make a map from drone photos and flight logs");
  command->add_option("IN", arguments->inputs, "Photos, logs, or folders of them (an SD card's DCIM will do)")
      ->required()
      ->check(CLI::ExistingPath);
  command
      ->add_option("-o,--out", arguments->out_dir,
                   "Folder for mosaic.mbtiles, report.json, photos.geojson, cameras.json and geo.txt, and "
                   "bands.tif of cameras with several bands; made if missing")
      ->required();
  AddGsdOptions(*command, arguments->job.mosaic.gsd_m, arguments->job.mosaic.any_gsd);
  for (const char* name : {"readout_ms", "quality", "format", "max_look_deg", "method"})
    AddJobOption(*command, name, arguments->job.mosaic);
  command
      ->add_option("--boundary", arguments->boundary,
                   "GeoJSON or KML file with a polygon: the map is cut to it. Photos are placed as without")
      ->check(CLI::ExistingFile);
  AddJobOption(*command, "takeoff_height_m", arguments->job.mosaic);
  command->add_option("--origin", arguments->origin,
                      "LAT,LON of the take-off in degrees, for a flight that recorded no position at all");
  AddJobOption(*command, "landed_at_start", arguments->job.mosaic);
  AddJobOption(*command, "surface", arguments->job.mosaic);
  command
      ->add_option("--dem", arguments->job.mosaic.dem_path,
                   "GeoTIFF with the ground's heights (default: one among the files, else what the photos "
                   "show)")
      ->check(CLI::ExistingFile);
  command->add_option("--title", arguments->job.mosaic.title, "Name of the map (default: the folder's name)");
  command
      ->add_option("--threads", arguments->job.mosaic.threads,
                   "Threads; 0 takes all cores. The map is the same with any number")
      ->capture_default_str();
  command->add_option("--max-memory", arguments->max_memory_gib, "Memory for photos and tiles in GiB")
      ->check(CLI::Range(0.25, 65536.0))
      ->capture_default_str();
  command
      ->add_option(
          "--formats", arguments->formats,
          "Also the map in other files, each as large as mosaic.mbtiles: utm (mosaic_utm.tif: a GeoTIFF in "
          "its UTM zone, to measure, for GIS and CAD), geotiff (mosaic.tif: a cloud-optimised GeoTIFF in "
          "Web Mercator, for web maps), pmtiles (mosaic.pmtiles), kmz (mosaic.kmz, for Google Earth); \"skyquilt "
          "export\" makes each of these later, and a server offers geotiff and pmtiles for download without "
          "storing them. And dsm: the heights of ground, roofs and trees as the photos show them (dsm.tif: a "
          "GeoTIFF in the UTM zone, in metres) with how many photos agree on each (dsm_photos.tif, 0 where it "
          "was filled in) and the shading of its slopes (dsm_hillshade.tif). And dtm: dsm, and the ground "
          "below houses and trees (dtm.tif) with where it was seen (dtm_ground.tif, 0 where it is bridged) "
          "and its contours (contours.gpkg, .geojson, .dxf). Those that the folder has of an earlier map are "
          "written again")
      ->delimiter(',')
      ->transform(OneOf(std::vector<std::pair<std::string, OtherFormat>>{{"geotiff", OtherFormat::kGeotiff},
                                                                         {"pmtiles", OtherFormat::kPmtiles},
                                                                         {"utm", OtherFormat::kUtm},
                                                                         {"kmz", OtherFormat::kKmz},
                                                                         {"dsm", OtherFormat::kDsm},
                                                                         {"dtm", OtherFormat::kDtm}}));
  command->add_flag("--no-cog", arguments->no_cog,
                    "No mosaic.tif, also where the folder has one of an earlier map");
  command->add_flag("--utm", arguments->utm, "As --formats utm");
  command
      ->add_option(
          "--layers", arguments->job.mosaic.layers,
          "Also tilesets of their own, with layers.json: photo (which photo a pixel came from), error (how far "
          "off it may lie), height (the ground's)")
      ->delimiter(',')
      ->transform(OneOf(
          std::vector<std::pair<std::string, render::MapLayer>>{{"photo", render::MapLayer::kPhoto},
                                                                {"error", render::MapLayer::kError},
                                                                {"height", render::MapLayer::kHeight}}));
  command->add_flag("--kmz", arguments->kmz, "As --formats kmz");
  command->add_flag("--no-pmtiles", arguments->no_pmtiles,
                    "No mosaic.pmtiles, also where the folder has one of an earlier map");
  CLI::Option* append = command->add_flag(
      "--append", arguments->append,
      "IN are photos more for the finished map in the folder: they are placed against it, and "
      "only the tiles below them are made anew, with its options, boundary and layers where nothing is said of "
      "them");
  command
      ->add_flag(
          "--overwrite", arguments->overwrite,
          "Replace whatever map the folder has. Without it a map of other photos, or one made with other "
          "options or with lists and logs that are not given now, stays, and nothing is done")
      ->excludes(append);
  command->add_flag(
      "--fresh", arguments->job.is_fresh,
      "Take nothing over from an earlier run. Without it a killed run goes on where it stopped, "
      "and photos that did not change are not compared again");
  command->add_option(
      "--trace", arguments->trace,
      "Also this file: what each thread did when, and each decision of the alignment with its "
      "numbers, a line each, for chrome://tracing, ui.perfetto.dev or grep");
  command->footer(
      "Example:\n"
      "  skyquilt stitch /media/sd/DCIM -o map\n"
      "  skyquilt stitch photos/ flight.BIN -o map\n"
      "  skyquilt stitch more/ -o map --append\n"
      "  skyquilt stitch photos/ -o map --formats utm && gdalinfo map/mosaic_utm.tif");
  command->callback([arguments, command] {
    for (const CLI::Option* option : command->get_options()) {
      if (option->count() > 0) arguments->said.insert(option->get_name());
    }
    Run(*arguments);
  });
}

}  // namespace skyquilt::server
