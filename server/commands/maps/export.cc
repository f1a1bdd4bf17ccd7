#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "core/flight/remarks/remark_words.h"
#include "core/indices/spectral_index.h"
#include "server/commands/arguments.h"
#include "server/commands/commands.h"
#include "server/terminal/fail.h"
#include "server/terminal/terminal_progress.h"
#include "server/usage/option_values.h"
#include "storage/exports/custom/export_map.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExportCommand = "skyquilt export";

struct ExportArguments {
  fs::path map;
  fs::path out;
  std::string format;
  fs::path clip;
  storage::ExportRequest request;  // as far as options say it word for word
  bool has_expression = false;     // which may be empty, and is refused then
  int quality = 85;
  int threads = 0;
  bool overwrite = false;
};

storage::ExportRequest ExportRequestOf(const ExportArguments& arguments) {
  storage::ExportRequest request = arguments.request;
  const auto format = arguments.format.empty()
                          ? storage::ExportFormatOfFile(arguments.out.filename().string())
                          : storage::ExportFormatOfName(arguments.format);
  if (!format)
    Refuse(
        kExportCommand,
        arguments.out.string() +
            " does not say its format. End its name in .tif, .pmtiles, .mbtiles or .kmz, or say --format. A PDF about the "
            "map is written by \"skyquilt report\".");
  request.format = *format;
  if (!request.crs.empty() && request.format != storage::ExportFormat::kGeotiff)
    Refuse(kExportCommand, std::string("--crs is for GeoTIFFs; ") + storage::NameOf(request.format) +
                               " is always in Web Mercator.");
  if (request.IsOfValues() && request.format != storage::ExportFormat::kGeotiff)
    Refuse(kExportCommand, "The values of an index are a GeoTIFF: end the file's name in .tif.");
  if (arguments.has_expression) {
    const auto parsed = indices::BandExpression::Parse(request.expression);
    if (!parsed) Refuse(kExportCommand, "--expression: " + parsed.error().message);
  }
  if (!arguments.clip.empty()) request.boundary = ReadBoundary(kExportCommand, arguments.clip);
  return request;
}

std::vector<std::string> IndexNames() {
  std::vector<std::string> names;
  for (const indices::SpectralIndex& index : indices::AllIndices()) names.emplace_back(index.name);
  return names;
}

void Run(const ExportArguments& arguments) {
  const storage::ExportRequest request = ExportRequestOf(arguments);
  const storage::ExportSource source = OrFail(kExportCommand, storage::ExportSourceOf(arguments.map));
  const fs::path out = fs::absolute(arguments.out);
  std::error_code error;
  for (const fs::path& own : {source.mbtiles, source.cog, source.bands}) {
    if (!own.empty() && fs::equivalent(out, own, error))
      Refuse(kExportCommand, out.string() + " is the map itself or a part of it; choose another name.");
  }
  CheckOutFile(kExportCommand, out, arguments.overwrite);
  const WorkFolder work(kExportCommand, HiddenBeside(out));
  OrFail(kExportCommand, [&] {
    TerminalProgress progress;
    return storage::ExportMap(source, request, work.path(), out, {arguments.quality, arguments.threads},
                              progress);
  }());
  fmt::print("{} ({:.1f} MB)\n", out.string(), static_cast<double>(fs::file_size(out, error)) / 1e6);
  const auto remark = OrFail(kExportCommand, storage::RemarkOnExport(source, request));
  if (remark) fmt::print("{}\n", flight::InWords(*remark));
}

}  // namespace

void AddExportCommand(CLI::App& app) {
  const auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand(
      "export", "Write a finished map as one file: another format, coordinate system, area or resolution");
  command
      ->add_option("MAP", arguments->map, "Folder that \"stitch\" wrote, or an .mbtiles; it stays as it is")
      ->required()
      ->check(CLI::ExistingPath);
  command
      ->add_option(
          "-o,--out", arguments->out,
          "File to write; its ending says the format: .tif (cloud-optimised GeoTIFF), .pmtiles, .mbtiles, "
          ".kmz (Google Earth)")
      ->required();
  command->add_option("--format", arguments->format, "The format, where the file's ending does not say it")
      ->check(OneOf({"geotiff", "pmtiles", "mbtiles", "kmz"}));
  command->add_option(
      "--crs", arguments->request.crs,
      "Coordinate system of a GeoTIFF: \"utm\" (the zone of the map's middle: to measure, for GIS and CAD) or a "
      "code such as EPSG:2056. Default: Web Mercator, as the map's tiles, which are copied: for web maps, its "
      "metres are too long");
  command
      ->add_option("--clip", arguments->clip,
                   "GeoJSON or KML file with a polygon: what lies outside is left out")
      ->check(CLI::ExistingFile);
  command
      ->add_option(
          "--resolution", arguments->request.resolution_m,
          "Ground that a pixel shows, in metres (0.1) or with its unit (10cm). A GeoTIFF has it exactly; of tiles the zooms down to it are "
          "written. Default: the map's own, the finest there is")
      ->transform(Length())
      ->check(CLI::PositiveNumber);
  CLI::Option* const index = command->add_option(
      "--index", arguments->request.index,
      "A GeoTIFF of the values of a vegetation index (ndvi, vari ...) as floats, instead of colours");
  index->check(OneOf(IndexNames()));
  CLI::Option* const expression =
      command->add_option("--expression", arguments->request.expression,
                          "The same by a formula over the map's bands, such as \"(nir-red)/(nir+red)\"");
  expression->excludes(index);
  command->add_option("--quality", arguments->quality, "JPEG quality of what has to be encoded anew")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "Threads; 0 takes all cores")->capture_default_str();
  command->add_flag("--overwrite", arguments->overwrite, "Replace the file if it is there");
  command->footer(
      "\nExample:\n"
      "  skyquilt export map -o field.tif --crs utm\n"
      "  skyquilt export map -o ndvi.tif --crs utm --index ndvi\n"
      "  skyquilt export map -o parcel.tif --crs EPSG:2056 --clip parcel.geojson --resolution 0.1\n"
      "  skyquilt export map -o small.pmtiles --resolution 0.25");
  command->callback([arguments, expression] {
    arguments->has_expression = expression->count() > 0;
    Run(*arguments);
  });
}

}  // namespace skyquilt::server
