#include "server/commands/data/import.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "core/base/scoped_folder.h"
#include "server/commands/fail.h"
#include "server/commands/terminal_progress.h"
#include "server/imports/enter_map.h"
#include "server/imports/import_map.h"
#include "storage/folder/elsewhere/settle_blobs.h"
#include "storage/folder/open_data_folder.h"
#include "storage/tags/flight_tags.h"
#include "storage/tilesets/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImportCommand = "skyquilt import";

struct ImportArguments {
  fs::path file;
  fs::path data_dir;
  ImportOptions options;
  std::vector<std::string> tags;
};

// Below incoming/, under a name that says it is temporary and ours; gone at the end unless it became a map.
class ImportFolder {
 public:
  explicit ImportFolder(const storage::DataDir& dir)
      : folder_(dir.Incoming() / dir.NewTemporaryName(storage::kImportKind)) {
    std::error_code error;
    if (!fs::create_directory(path(), error))
      Fail(kImportCommand, storage::FileError("cannot make", path(), error.value()));
  }
  const fs::path& path() const { return folder_.path(); }

 private:
  ScopedFolder folder_;
};

storage::OpenedDataFolder OpenForImport(const fs::path& data_dir) {
  Result<storage::OpenedDataFolder> opened = storage::OpenDataFolder(data_dir);
  if (!opened) Fail(kImportCommand, opened.error());
  const Result<std::optional<std::string>> elsewhere = storage::SettledAt(opened->dir);
  if (!elsewhere) Fail(kImportCommand, elsewhere.error());
  if (*elsewhere)
    Fail(kImportCommand,
         {ErrorCode::kConflict,
          data_dir.string() + " keeps its maps at " + **elsewhere +
              ". A map is imported into a folder of its own, which \"skyquilt data move\" brings there.",
          ""});
  return *std::move(opened);
}

void Run(ImportArguments& arguments) {
  ImportOptions& options = arguments.options;
  if (options.title.empty()) options.title = arguments.file.stem().string();
  auto tags = storage::CheckedTags(arguments.tags);
  if (!tags) Fail(kImportCommand, {ErrorCode::kInvalidArgument, "--tag: " + tags.error().message, ""});
  const storage::OpenedDataFolder opened = OpenForImport(arguments.data_dir);
  const ImportFolder folder(opened.dir);
  const Result<pipeline::MosaicReport> report = [&] {
    TerminalProgress progress;
    return ImportMap(arguments.file, folder.path(), options, progress);
  }();
  if (!report) Fail(kImportCommand, report.error());
  const Result<std::string> flight_id = EnterMap(opened, folder.path(), options.title, *tags);
  if (!flight_id) Fail(kImportCommand, flight_id.error());
  fmt::print("{:.2f} ha at {:.3g} cm a pixel, {} tiles of zoom {} to {}\nflight {}\n", report->area_m2 / 1e4,
             report->gsd_m * 100.0, report->tile_count, report->min_zoom, report->max_zoom, *flight_id);
  fmt::print("To see it: skyquilt serve --data {}, then /#/flights/{}\n", opened.dir.root().string(),
             *flight_id);
}

}  // namespace

void AddImportCommand(CLI::App& app) {
  const auto arguments = std::make_shared<ImportArguments>();
  CLI::App* command =
      app.add_subcommand("import", "Take a finished map of others into a data folder, to be served");
  command
      ->add_option(
          "FILE", arguments->file,
          "Georeferenced GeoTIFF (8 bits a colour, any coordinate system), or an MBTiles of pictures; it "
          "stays as it is")
      ->required()
      ->check(CLI::ExistingFile);
  command
      ->add_option("--data", arguments->data_dir,
                   "Data folder of \"serve\", which must not be running; made where it is missing")
      ->required();
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
  command->add_option("--threads", arguments->options.threads, "Threads; 0 takes all cores")
      ->capture_default_str();
  command->footer(
      "\nThe map becomes a flight without photos: it is served, shared and exported like any other.\n"
      "Example:\n"
      "  skyquilt import orthophoto.tif --data data --name \"Field 7, 2019\"");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
