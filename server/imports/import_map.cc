#include "server/imports/import_map.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "server/imports/import_raster.h"
#include "server/imports/import_tiles.h"
#include "server/imports/imported_tileset.h"
#include "server/imports/told_quality.h"
#include "server/tileset_metadata.h"
#include "storage/exports/thumbnail_writer.h"
#include "storage/files/publish_file.h"

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

}  // namespace skyquilt::server
