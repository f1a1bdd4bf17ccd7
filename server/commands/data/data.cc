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
#include "storage/folder/check_data.h"
#include "storage/folder/data_marker.h"
#include "storage/folder/lost_folder.h"
#include "storage/folder/object_store/move_blobs.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/folder/open_data_folder.h"
#include "storage/folder/repair_data.h"
#include "storage/folder/shared_catalogue.h"

namespace skyquilt::server {
namespace {

// Exit codes beside 0: 1, it could not be done; 2, check found differences, or purge-lost wants --yes.
constexpr int kFound = 2;

struct DataOptions {
  std::string data_dir;
  CatalogueOptions catalogue;
  storage::BlobPlace blobs;
  std::string from, to;  // of move
  bool deep = false;
  bool remove_source = false;
  bool yes = false;
};

// A folder that is ours, kept from servers for as long as the lock lives.
struct Held {
  storage::DataDir dir;
  storage::DataDirLock lock;
  std::optional<std::string> id;
};

Held Hold(const DataOptions& options) {
  const storage::DataDir at = storage::DataDir::At(options.data_dir);
  const storage::FolderSurvey survey = OrFail("skyquilt data", storage::SurveyFolder(at));
  const Result<std::optional<std::string>> marker = storage::ReadMarker(at);
  if (!marker && marker.error().code == ErrorCode::kCorrupt) {
    Fail("skyquilt data", {ErrorCode::kCorrupt, marker.error().message + " " + storage::RepairAdvice(at)});
  }
  if (!marker) Fail("skyquilt data", marker.error());
  if (!*marker && !survey.has_flights && !survey.has_catalogue) {
    Fail("skyquilt data",
         {ErrorCode::kNotFound,
          at.root().string() +
              " is not a data folder of Skyquilt: it has neither skyquilt-data.json nor a catalogue."});
  }
  storage::DataDirLock lock = OrFail("skyquilt data", storage::DataDirLock::Take(at));
  return {at, std::move(lock), *marker};
}

void PrintLost(const std::vector<storage::LostItem>& lost) {
  for (const storage::LostItem& item : lost) {
    fmt::print("  lost/{}: {}, {:.1f} MB\n", item.folder.filename().string(), Counted(item.files, "file"),
               static_cast<double>(item.bytes) / 1e6);
  }
}

void PrintLines(const char* head, const std::vector<std::string>& lines) {
  if (lines.empty()) return;
  fmt::print("{}: {}\n", head, lines.size());
  for (const std::string& line : lines) fmt::print("  {}\n", line);
}

void Check(const DataOptions& options) {
  const Held held = Hold(options);
  const storage::CataloguePlace place = PlaceOf("skyquilt data", options.catalogue);
  const auto unusable = [&](const std::string& why) {
    fmt::print("The catalogue {} {}. {}\n", storage::NameOfCatalogue(held.dir, place), why,
               storage::RepairAdvice(held.dir, place));
    throw CLI::RuntimeError(kFound);
  };
  const Result<std::unique_ptr<storage::CatalogueDb>> db = storage::OpenCatalogueOf(held.dir, place);
  if (!db && db.error().code == ErrorCode::kNotFound) unusable("is missing or empty");
  if (!db && db.error().code == ErrorCode::kCorrupt) unusable("is damaged");
  if (!db) Fail("skyquilt data", db.error());
  if (!storage::CheckWhole(held.dir, **db)) unusable("is damaged");
  const std::optional<std::string> owner = OrFail("skyquilt data", storage::CatalogueId(*(*db)->Lock()));
  if (held.id && owner && *owner != *held.id) unusable("belongs to another data folder");
  // Where the folder says that they lie, unless told otherwise.
  storage::BlobPlace blob_place = options.blobs;
  const std::optional<std::string> settled = OrFail("skyquilt data", storage::SettledAt(held.dir));
  if (blob_place.address.empty() && settled) blob_place.address = *settled;
  const std::shared_ptr<storage::BlobStore> blobs =
      OrFail("skyquilt data", storage::OpenBlobs(blob_place, held.dir.root()));
  storage::DataCheck check = OrFail("skyquilt data", storage::CheckData(held.dir, **db, blobs.get()));
  if (options.deep) {
    TerminalProgress progress;
    OrFail("skyquilt data", storage::CheckMaps(**db, *blobs, check, progress));
  }
  fmt::print("{}: {}, {} of {:.1f} MB and {} in the catalogue\n", held.dir.root().string(),
             Counted(check.flights, "flight"), Counted(check.files, "file"),
             static_cast<double>(check.bytes) / 1e6, Counted(check.maps, "map"));
  PrintLines("in the catalogue, but not (whole) on disk", check.missing);
  PrintLines("on disk, but not in the catalogue", check.unknown);
  PrintLines("of maps, but not as their jobs left them", check.changed);
  if (check.maps_without_sums > 0)
    fmt::print(
        "{} not compared: of maps in a folder, moved ones and those of earlier versions no SHA-256 is kept\n",
        Counted(check.maps_without_sums, "map was", "maps were"));
  if (!check.lost.empty()) {
    fmt::print("in lost/, until \"skyquilt data purge-lost\" removes it:\n");
    PrintLost(check.lost);
  }
  if (check.IsWell()) {
    fmt::print("all is well\n");
    return;
  }
  if (!check.changed.empty())
    fmt::print(
        "A server shows none of these files. Put back good copies from a backup of the store, or start a job of their "
        "flight again, which makes a new map.\n");
  if (settled && !check.unknown.empty()) {
    fmt::print(
        "What is unknown stays at {0}. \"skyquilt data repair\" enters what lies in the folder alone: put back a newer "
        "copy of the catalogue, or run the repair, which says what to copy first.\n",
        *settled);
  } else if (!check.unknown.empty() || !check.lost.empty()) {
    fmt::print("\"skyquilt data repair --data {}\" brings back what belongs to flights.\n",
               held.dir.root().string());
  }
  throw CLI::RuntimeError(kFound);
}

void Repair(const DataOptions& options) {
  const storage::DataDir dir = storage::DataDir::At(options.data_dir);
  const std::optional<std::string> settled = OrFail("skyquilt data", storage::SettledAt(dir));
  if (settled) {
    Fail(
        "skyquilt data",
        {ErrorCode::kConflict,
         fmt::format(
             "A catalogue is made anew from photos in the folder, and those of {0} lie at {1}. Copy what is "
             "below {1}flights/ into {0}/flights with any S3 client, remove {2}, and repair then; or put back "
             "a good copy of the catalogue. Nothing was changed.",
             dir.root().string(), *settled, dir.BlobsMarker().string())});
  }
  const storage::RepairReport report = OrFail(
      "skyquilt data",
      storage::RepairData(options.data_dir, storage::Now(), PlaceOf("skyquilt data", options.catalogue)));
  for (const std::string& line : report.lines) fmt::print("{}\n", line);
  fmt::print("{}, {} and {} were entered into {} catalogue\n", Counted(report.flights, "flight"),
             Counted(report.files, "file"), Counted(report.maps, "map"),
             report.made_catalogue ? "a new" : "the");
}

void Purge(const DataOptions& options) {
  const Held held = Hold(options);
  const std::vector<storage::LostItem> lost = storage::ListLost(held.dir);
  if (lost.empty()) {
    fmt::print("There is nothing in {}.\n", held.dir.Lost().string());
    return;
  }
  fmt::print("{}:\n", options.yes ? "Removing for good" : "This would be removed for good");
  PrintLost(lost);
  if (!options.yes) {
    fmt::print("Nothing was removed. Say it again with --yes.\n");
    throw CLI::RuntimeError(kFound);
  }
  OrFail("skyquilt data", storage::PurgeLost(held.dir));
}

void Move(const DataOptions& options) {
  if (options.from.empty() == options.to.empty()) {
    Refuse("skyquilt data move",
           "Say where to or where from: --to s3://bucket/prefix, or --from s3://bucket/prefix.");
  }
  const storage::CataloguePlace given = PlaceOf("skyquilt data move", options.catalogue);
  const storage::CataloguePlace catalogue_place = OrFail(
      "skyquilt data move", storage::WithFilesAt(given, {.address = given.IsPostgres() ? options.from : ""}));
  const storage::OpenedDataFolder opened =
      OrFail("skyquilt data move", storage::OpenDataFolder(options.data_dir, 1, catalogue_place));
  const storage::BlobPlace place{options.from + options.to, storage::kUsualCacheBytes};
  const std::shared_ptr<storage::BlobStore> far =
      OrFail("skyquilt data move", storage::OpenBlobs(place, opened.dir.root()));
  storage::FolderBlobs near(opened.dir.root());
  const bool goes_out = options.from.empty();
  TerminalProgress progress;
  const storage::MoveReport moved = OrFail(
      "skyquilt data move", storage::MoveBlobs(opened.dir, opened.dir.id(), *opened.db,
                                               goes_out ? static_cast<storage::BlobStore&>(near) : *far,
                                               goes_out ? *far : static_cast<storage::BlobStore&>(near),
                                               options.remove_source, progress));
  fmt::print("{} copied and {} there already, {:.1f} MB in all; each was read back and is the same\n",
             Counted(moved.copied, "file was", "files were"), Counted(moved.there_already, "was", "were"),
             static_cast<double>(moved.bytes) / 1e6);
  if (moved.pack.packed > 0)
    fmt::print("{} packed beside, so that tiles are read there without fetching the map\n",
               Counted(moved.pack.packed, "map was", "maps were"));
  for (const std::string& map : moved.pack.left_whole)
    fmt::print("Not packed, its tiles need the whole map fetched: {}\n", map);
  if (moved.removed > 0) fmt::print("{} removed\n", Counted(moved.removed, "original was", "originals were"));
  if (moved.removed == 0 && moved.bytes > 0)
    fmt::print("The originals are still there; the same command with --remove-source removes them.\n");
  if (goes_out) fmt::print("Start the server with --blobs {}\n", far->Address());
  if (!goes_out) fmt::print("Start the server without --blobs\n");
}

}  // namespace

void AddDataCommand(CLI::App& app) {
  const auto options = std::make_shared<DataOptions>();
  CLI::App* command =
      app.add_subcommand("data", "Check, repair or move the data of a server that is stopped");
  command->require_subcommand(1);
  const auto add = [&](const char* name, const char* about, const char* more) {
    CLI::App* sub = command->add_subcommand(name, about);
    sub->add_option("--data", options->data_dir, "Data folder of the server")->required();
    AddCatalogueOptions(*sub, options->catalogue);
    sub->footer(more);
    return sub;
  };
  CLI::App* check = add(
      "check", "Compare the catalogue with what is on disk",
      "Lists what the catalogue knows and the disk lacks, what is on disk and the catalogue does not know, and what lies in "
      "lost/. Changes nothing.\nExit codes: 0 all is well, 1 it could not be checked, 2 there are differences.");
  check->add_flag(
      "--deep", options->deep,
      "Also read every file of the maps in a store and compare it with the SHA-256 that the catalogue keeps of "
      "it: takes as long as fetching all maps");
  check->callback([options] { Check(*options); });
  add("repair", "Make the catalogue anew from the flights on disk, or complete it",
      "A catalogue that is missing, damaged or of another folder is set aside in lost/ and made anew; one that can be used "
      "is kept and only added to. Flights, photos and maps on disk and in lost/ come back under their names. Nothing is "
      "removed. Of a catalogue that is lost, tokens, webhooks and jobs are lost with it.")
      ->callback([options] { Repair(*options); });
  CLI::App* move = add(
      "move", "Move photos and maps to S3, or back into the folder",
      "Each copy is read back and compared with its original. What was cut off goes on where it was when the same command "
      "is run again. Endpoint, region and keys come from AWS_... variables, a profile or the machine's role.");
  move->add_option("--to", options->to, "Where to: s3://bucket/prefix");
  move->add_option("--from", options->from, "Where from, back into the folder: s3://bucket/prefix");
  move->add_flag("--remove-source", options->remove_source,
                 "Remove the originals once all copies are verified");
  move->callback([options] { Move(*options); });
  CLI::App* purge =
      add("purge-lost", "Remove what lies in lost/, for good",
          "lost/ holds what the server found in its folder and nothing referred to. Without --yes it is only "
          "listed (exit code 2).");
  purge->add_flag("--yes", options->yes, "Remove it");
  purge->callback([options] { Purge(*options); });
}

}  // namespace skyquilt::server
