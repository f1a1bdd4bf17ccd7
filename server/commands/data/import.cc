#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/text/json_io.h"
#include "core/base/text/printable.h"
#include "server/commands/arguments.h"
#include "server/commands/commands.h"
#include "server/imports/import_map.h"
#include "server/terminal/fail.h"
#include "server/terminal/terminal_progress.h"
#include "storage/files/data_dir.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/folder/open_data_folder.h"
#include "storage/tags/flight_tags.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImportCommand = "skyquilt import";

struct ImportArguments {
  fs::path file;
  fs::path data_dir;  // or, of a server:
  UploadOptions upload;
  int patience_s = 600;
  bool no_wait = false;
  ImportOptions options;
  std::vector<std::string> tags;
};

storage::OpenedDataFolder OpenForImport(const fs::path& data_dir) {
  storage::OpenedDataFolder opened = OrFail(kImportCommand, storage::OpenDataFolder(data_dir));
  const std::optional<std::string> elsewhere = OrFail(kImportCommand, storage::SettledAt(opened.dir));
  if (elsewhere)
    Fail(kImportCommand,
         {ErrorCode::kConflict,
          data_dir.string() + " keeps its maps at " + *elsewhere +
              ". A map is imported into a folder of its own, which \"skyquilt data move\" brings there."});
  return opened;
}

void ImportIntoFolder(ImportArguments& arguments) {
  arguments.options.report_json = ReportBeside(arguments.file);
  const ImportOptions& options = arguments.options;
  const storage::OpenedDataFolder opened = OpenForImport(arguments.data_dir);
  // Under a name that says it is temporary and ours; what became a map is no longer there at the end.
  const WorkFolder folder(kImportCommand,
                          opened.dir.Incoming() / opened.dir.NewTemporaryName(storage::kImportKind));
  const pipeline::MosaicReport report = OrFail(kImportCommand, [&] {
    TerminalProgress progress;
    return ImportMap({arguments.file.string(), arguments.file}, folder.path(), options, progress);
  }());
  const std::string flight_id =
      OrFail(kImportCommand, EnterMap(opened, folder.path(), options.title, arguments.tags));
  fmt::print("{:.2f} ha at {:.3g} cm a pixel, {} of zoom {} to {}\nflight {}\n", report.area_m2 / 1e4,
             report.gsd_m * 100.0, Counted(report.tile_count, "tile"), report.min_zoom, report.max_zoom,
             flight_id);
  fmt::print("To see it: skyquilt serve --data {}, then /#/flights/{}\n", opened.dir.root().string(),
             flight_id);
}

// The server has the file looked at by a process that reaches nothing else, as it has photos.
void ImportByServer(ImportArguments& arguments) {
  UploadOptions& upload = arguments.upload;
  CheckServerAddress(kImportCommand, upload.server.url);
  const std::string name = arguments.file.filename().string();
  upload.server.patience = std::chrono::seconds(arguments.patience_s);
  upload.name = arguments.options.title;
  upload.tags = arguments.tags;
  upload.waits = !arguments.no_wait;
  upload.job_options = JsonText(nlohmann::json{{"quality", arguments.options.quality}});
  upload.import_file = name;
  std::vector<flight::InputFile> files = {{name, arguments.file}};
  const fs::path report = ReportBeside(arguments.file);
  // A file of that name may be anybody's: what is none of a map is not sent.
  if (!ReportText(report).empty()) files.push_back({report.filename().string(), report});
  upload.replaced_file = report.filename().string();  // a job knows it by that name alone
  const UploadedFlight uploaded = UploadAtTerminal(kImportCommand, files, upload);
  fmt::print("flight {}\nTo see it: {}/#/flights/{}\n", uploaded.flight_id, upload.server.url,
             uploaded.flight_id);
}

void Run(ImportArguments& arguments) {
  if (arguments.data_dir.empty() && arguments.upload.server.url.empty())
    Refuse(kImportCommand,
           "Say where the map goes: --server with the address of a running server, or --data "
           "with the data folder of one that does not run.");
  if (arguments.options.title.empty()) arguments.options.title = NameOfInput(arguments.file);
  auto tags = storage::CheckedTags(arguments.tags);
  if (!tags) Refuse(kImportCommand, "--tag: " + tags.error().message);
  arguments.tags = *std::move(tags);
  if (arguments.data_dir.empty()) {
    ImportByServer(arguments);
  } else {
    ImportIntoFolder(arguments);
  }
}

}  // namespace

void AddImportCommand(CLI::App& app) {
  const auto arguments = std::make_shared<ImportArguments>();
  CLI::App* command =
      app.add_subcommand("import", "Take a finished map of others onto a server, or into its data folder");
  command
      ->add_option(
          "FILE", arguments->file,
          "Georeferenced GeoTIFF (8 bits a colour, any coordinate system), or an MBTiles of pictures; it "
          "stays as it is")
      ->required()
      ->check(CLI::ExistingFile);
  CLI::Option* server = command->add_option("--server", arguments->upload.server.url,
                                            "Address of a running server, to which the file is sent");
  CLI::Option* data = command->add_option(
      "--data", arguments->data_dir,
      "Instead: data folder of \"serve\", which must not be running; made where it is missing");
  data->excludes(server);
  command
      ->add_option("--token", arguments->upload.server.token, "With --server: token, where it asks for one")
      ->envname("SKYQUILT_TOKEN");
  command->add_option("--name", arguments->options.title, "Name of the flight (default: that of the file)");
  command
      ->add_option("--tag", arguments->tags,
                   "Word by which the flight is found again; may be given several times")
      ->allow_extra_args(false);
  command
      ->add_option("--quality", arguments->options.quality,
                   "JPEG quality of tiles that are made from a GeoTIFF")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_option("--threads", arguments->options.threads, "With --data: threads; 0 takes all cores")
      ->needs(data)
      ->capture_default_str();
  command
      ->add_option("--flight", arguments->upload.flight_id,
                   "With --server: id of a flight that is there, whose map it becomes")
      ->needs(server);
  command
      ->add_option("--patience", arguments->patience_s,
                   "With --server: seconds that one which does not answer is asked again")
      ->check(CLI::Range(0, 86'400))
      ->needs(server)
      ->capture_default_str();
  command
      ->add_flag("--no-wait", arguments->no_wait,
                 "With --server: end when the file is sent and the import is queued")
      ->needs(server);
  command->footer(
      "\nThe map becomes a flight without photos: it is served, shared and exported like any other.\n"
      "How accurate it is, the report.json beside the file says where it is of this map; else it is not "
      "known.\n"
      "On a server the file stays among the flight's files until it is deleted there.\n"
      "Examples:\n"
      "  skyquilt import orthophoto.tif --server http://maps.example:8080\n"
      "  skyquilt import orthophoto.tif --data data --name \"Field 7, 2019\"");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
