#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "core/base/text/printable.h"
#include "server/commands/commands.h"
#include "server/terminal/fail.h"
#include "server/terminal/terminal_progress.h"
#include "server/usage/storage_options.h"
#include "storage/blobs/folder_blobs.h"
#include "storage/blobs/open_blobs.h"
#include "storage/folder/object_store/move_blobs.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/folder/open_data_folder.h"

namespace skyquilt::server {
namespace {

struct MoveOptions {
  std::string data_dir;
  std::string from, to;
  CatalogueOptions catalogue;
  bool remove_source = false;
};

void Move(const MoveOptions& options) {
  if (options.from.empty() == options.to.empty()) {
    Fail("skyquilt data move",
         {ErrorCode::kInvalidArgument,
          "Say where to or where from: --to s3://bucket/prefix, or --from s3://bucket/prefix.", ""});
  }
  const storage::CataloguePlace given = PlaceOf("skyquilt data move", options.catalogue);
  const Result<storage::CataloguePlace> catalogue_place =
      storage::WithFilesAt(given, {.address = given.IsPostgres() ? options.from : ""});
  if (!catalogue_place) Fail("skyquilt data move", catalogue_place.error());
  const Result<storage::OpenedDataFolder> opened =
      storage::OpenDataFolder(options.data_dir, 1, *catalogue_place);
  if (!opened) Fail("skyquilt data move", opened.error());
  const storage::BlobPlace place{options.from + options.to, storage::kUsualCacheBytes};
  const Result<std::shared_ptr<storage::BlobStore>> far = storage::OpenBlobs(place, opened->dir.root());
  if (!far) Fail("skyquilt data move", far.error());
  storage::FolderBlobs near(opened->dir.root());
  const bool goes_out = options.from.empty();
  TerminalProgress progress;
  const Result<storage::MoveReport> moved = storage::MoveBlobs(
      opened->dir, opened->dir.id(), *opened->db, goes_out ? static_cast<storage::BlobStore&>(near) : **far,
      goes_out ? **far : static_cast<storage::BlobStore&>(near), options.remove_source, progress);
  if (!moved) Fail("skyquilt data move", moved.error());
  fmt::print("{} copied and {} there already, {:.1f} MB in all; each was read back and is the same\n",
             Counted(moved->copied, "file was", "files were"), Counted(moved->there_already, "was", "were"),
             static_cast<double>(moved->bytes) / 1e6);
  if (moved->pack.packed > 0)
    fmt::print("{} packed beside, so that tiles are read there without fetching the map\n",
               Counted(moved->pack.packed, "map was", "maps were"));
  for (const std::string& map : moved->pack.left_whole)
    fmt::print("Not packed, its tiles need the whole map fetched: {}\n", map);
  if (moved->removed > 0)
    fmt::print("{} removed\n", Counted(moved->removed, "original was", "originals were"));
  if (moved->removed == 0 && moved->bytes > 0)
    fmt::print("The originals are still there; the same command with --remove-source removes them.\n");
  if (goes_out) fmt::print("Start the server with --blobs {}\n", (*far)->Address());
  if (!goes_out) fmt::print("Start the server without --blobs\n");
}

}  // namespace

void AddMoveCommand(CLI::App& data) {
  const auto options = std::make_shared<MoveOptions>();
  CLI::App* command = data.add_subcommand("move", "Move photos and maps to S3, or back into the folder");
  command->add_option("--data", options->data_dir, "Data folder of the server")->required();
  command->add_option("--to", options->to, "Where to: s3://bucket/prefix");
  command->add_option("--from", options->from, "Where from, back into the folder: s3://bucket/prefix");
  AddCatalogueOptions(*command, options->catalogue);
  command->add_flag("--remove-source", options->remove_source,
                    "Remove the originals once all copies are verified");
  command->footer(
      "Each copy is read back and compared with its original. What was cut off goes on where it was when the same command "
      "is run again. Endpoint, region and keys come from AWS_... variables, a profile or the machine's role.");
  command->callback([options] { Move(*options); });
}

}  // namespace skyquilt::server
