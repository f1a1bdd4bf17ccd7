#include "server/imports/import_map.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "server/imports/imported_tileset.h"
#include "server/imports/told_quality.h"
#include "server/tileset_metadata.h"
#include "storage/catalogue/catalogue.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/exports/thumbnail_writer.h"
#include "storage/files/publish_file.h"
#include "storage/folder/enter_flight.h"
#include "storage/folder/open_data_folder.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr int kImportThumbnailPx = 512;
constexpr std::uintmax_t kMaxReportBytes = std::uintmax_t{32} << 20;

bool IsSqlite(const fs::path& file) {
  std::array<char, 16> head{};
  std::ifstream(file, std::ios::binary).read(head.data(), head.size());
  return std::string_view(head.data(), 15) == "SQLite format 3";
}

constexpr std::int64_t kKeepFreeBytes = std::int64_t{512} << 20;
constexpr std::int64_t kMinRoomBytes = std::int64_t{1} << 20;

constexpr std::int64_t kFirstRevision = 1;

Result<void> PutInPlace(const storage::OpenedDataFolder& opened, const fs::path& products,
                        const std::string& flight_id) {
  const fs::path place = opened.dir.Revision(flight_id, kFirstRevision);
  SKYQUILT_TRY(storage::SyncFolder(products));
  std::error_code error;
  fs::rename(products, place, error);
  if (error) return storage::FileError("cannot make", place, error.value());
  SKYQUILT_TRY(storage::SyncFolder(opened.dir.Flight(flight_id)));
  storage::DiskFlight on_disk;
  on_disk.id = flight_id;
  on_disk.folder = opened.dir.Flight(flight_id);
  on_disk.revisions = {kFirstRevision};
  SKYQUILT_TRY_ASSIGN(const storage::EnteredFlight entered,
                      storage::EnterFlight(*opened.db, on_disk, std::nullopt));
  if (!entered.revision)
    return Error{ErrorCode::kInternal, "The map was made, but the catalogue did not take it.",
                 place.string()};
  return {};
}

}  // namespace

storage::TilesetMetadata MetadataOfImport(const pipeline::MosaicReport& report,
                                          const std::string& attribution) {
  storage::TilesetMetadata metadata = TilesetMetadataOf(report);
  metadata.description = "Imported map";
  metadata.attribution = attribution;
  return metadata;
}

std::string ReportText(const fs::path& file) {
  std::error_code none;
  const std::uintmax_t bytes = fs::file_size(file, none);
  if (none || bytes > kMaxReportBytes) return {};
  Result<std::string> text = storage::ReadWholeFile(file);
  return text && IsReportOfAMap(*text) ? *std::move(text) : std::string();
}

fs::path ReportBeside(const fs::path& file) { return file.parent_path() / "report.json"; }

Result<pipeline::MosaicReport> ImportMap(const flight::InputFile& file, const fs::path& out_dir,
                                         const ImportOptions& options, Progress& progress) {
  pipeline::MosaicReport report;
  report.title = options.title;
  report.height_rule = "none: an imported map";
  report.warnings.push_back(
      {flight::RemarkCode::kImported, {{"file", fs::path(file.name).filename().string()}}});
  const fs::path mbtiles = out_dir / "mosaic.mbtiles";
  progress.BeginStage("import");
  const bool is_of_tiles = IsSqlite(file.path);
  SKYQUILT_TRY(is_of_tiles ? ImportTiles(file, mbtiles, report, progress)
                           : ImportRaster(file, mbtiles, options, report, progress));
  report.quality.status = pipeline::MapStatus::kUnknown;
  if (auto told = ToldOfMap(ReportText(options.report_json), report, is_of_tiles)) {
    report.quality = std::move(told->quality);
    report.gsd_m = told->gsd_m;
    report.area_m2 = told->area_m2;
  }
  progress.BeginStage("export");
  SKYQUILT_TRY(storage::WriteTilesThumbnail(mbtiles, out_dir / "thumbnail.png", kImportThumbnailPx));
  for (const auto& [name, text] :
       {std::pair{"photos.geojson", std::string(R"({"type":"FeatureCollection","features":[]})"
                                                "\n")},
        std::pair{"report.json", pipeline::ReportJson(report)}}) {
    SKYQUILT_TRY(storage::WriteFileAtomically(out_dir / name, text));
  }
  return report;
}

std::int64_t RoomForImport(const fs::path& folder) {
  std::error_code unknown;
  const fs::space_info disk = fs::space(folder, unknown);
  if (unknown) return kMinRoomBytes;
  return std::max(kMinRoomBytes, static_cast<std::int64_t>(disk.available) - kKeepFreeBytes);
}

Result<pipeline::MosaicReport> ImportForJob(const std::vector<flight::InputFile>& files,
                                            const pipeline::MosaicOptions& options, const ImportJob& job,
                                            Progress& progress) {
  const auto file = std::find_if(files.begin(), files.end(), [&](const flight::InputFile& one) {
    return one.name == options.import_file;
  });
  if (file == files.end())
    return flight::Because(ErrorCode::kUnprocessable,
                           {flight::RemarkCode::kFailImportMissing, {{"file", options.import_file}}});
  const auto told = std::find_if(files.begin(), files.end(), [&](const flight::InputFile& one) {
    return fs::path(one.name) == ReportBeside(file->name);
  });
  const ImportOptions how{options.title, options.jpeg_quality, options.threads,
                          told == files.end() ? fs::path() : told->path};
  Result<pipeline::MosaicReport> report = ImportMap(*file, job.out_dir, how, progress);
  if (report && job.with_pmtiles) {
    SKYQUILT_TRY(
        storage::WritePmtiles(job.out_dir / "mosaic.mbtiles", job.out_dir / "mosaic.pmtiles", progress));
  }
  return report;
}

Result<std::string> EnterMap(const storage::OpenedDataFolder& opened, const fs::path& products,
                             const std::string& name, const std::vector<std::string>& tags) {
  storage::Catalogue catalogue(*opened.db, storage::FlightRecords(opened.dir));
  storage::FlightChange marks;
  marks.tags = tags;
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight,
                      catalogue.AddFlight(name, "{}", storage::Now(), "", marks));
  const Result<void> placed = PutInPlace(opened, products, flight.id);
  if (placed) return flight.id;
  // The flight is this call's own and was shown to nobody.
  std::error_code stays;  // the sweep of the next server moves it to lost/
  fs::rename(opened.dir.Revision(flight.id, kFirstRevision), products, stays);
  (void)catalogue.DeleteFlight(flight.id).ok();
  return placed.error();
}

}  // namespace skyquilt::server
