#include "storage/validation/validate_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <span>
#include <system_error>

#include "core/base/try.h"

namespace skyquilt::storage {

const char* SeverityName(Severity severity) {
  return severity == Severity::kError ? "error" : severity == Severity::kWarning ? "warning" : "note";
}

bool FileVerdict::Has(Severity severity) const {
  return std::any_of(findings.begin(), findings.end(),
                     [&](const Finding& finding) { return finding.severity == severity; });
}

void CountedFindings::Add(Severity severity, const std::string& kind, const std::string& example) {
  constexpr std::size_t kExamples = 3;
  Counted& counted = counted_[{severity, kind}];
  ++counted.count;
  if (counted.first.size() < kExamples) counted.first.push_back(example);
}

void CountedFindings::MoveTo(FileVerdict& verdict) {
  for (const auto& [what, counted] : counted_) {
    std::string examples;
    for (const std::string& example : counted.first) examples += (examples.empty() ? "" : ", ") + example;
    verdict.Add(what.first, fmt::format("{} {} ({}{})", counted.count, what.second, examples,
                                        counted.count > std::ssize(counted.first) ? ", ..." : ""));
  }
  counted_.clear();
}

namespace {

namespace fs = std::filesystem;

using Validate = Result<FileVerdict> (*)(const fs::path&, bool, Progress&);

// By the first bytes.
Validate ValidatorFor(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 16> head{};
  file.read(head.data(), head.size());
  const std::string_view begins(head.data(), static_cast<std::size_t>(file.gcount()));
  if (begins.starts_with("PMTiles")) return ValidatePmtiles;
  if (begins.starts_with("SQLite format 3")) return ValidateMbtiles;
  const bool is_tiff = begins.starts_with(std::string_view("II*\0", 4)) || begins.starts_with("II+") ||
                       begins.starts_with(std::string_view("MM\0*", 4)) ||
                       begins.starts_with(std::string_view("MM\0+", 4));
  if (is_tiff) return ValidateGeotiff;
  // One whose beginning is damaged is of the kind that its name says.
  const std::string ending = path.extension().string();
  if (ending == ".mbtiles") return ValidateMbtiles;
  if (ending == ".pmtiles") return ValidatePmtiles;
  if (ending == ".tif" || ending == ".tiff") return ValidateGeotiff;
  return nullptr;
}

// What reports speak of, and what lies beside it where it was asked for: each sound or not by itself.
constexpr std::array kTiles = {"mosaic.mbtiles", "mosaic.pmtiles", "mosaic.tif"};
constexpr std::array kRasters = {"mosaic_utm.tif",    "bands.tif", "dsm.tif",       "dsm_photos.tif",
                                 "dsm_hillshade.tif", "dtm.tif",   "dtm_ground.tif"};

Result<void> JudgeThoseOf(const fs::path& folder, std::span<const char* const> names, bool quick,
                          Progress& progress, std::vector<FileVerdict>& verdicts) {
  std::error_code gone;
  for (const char* name : names) {
    const fs::path path = folder / name;
    if (!fs::exists(path, gone)) continue;
    progress.BeginStage(name);
    SKYQUILT_TRY_ASSIGN(FileVerdict verdict, ValidatorFor(path)(path, quick, progress));
    verdicts.push_back(std::move(verdict));
  }
  return {};
}

Result<std::vector<FileVerdict>> ValidateFolder(const fs::path& folder, bool quick, Progress& progress) {
  std::vector<FileVerdict> verdicts;
  std::error_code gone;
  SKYQUILT_TRY(JudgeThoseOf(folder, kTiles, quick, progress, verdicts));
  std::vector<FileVerdict> reports = ValidateReports(folder, verdicts);
  if (verdicts.empty() && reports.empty())
    return Error{ErrorCode::kUnsupportedFormat,
                 folder.string() +
                     " is no map: it has neither mosaic.mbtiles, mosaic.pmtiles, mosaic.tif nor "
                     "report.json. Name the folder that \"skyquilt stitch -o\" wrote, or a file.",
                 ""};
  SKYQUILT_TRY(JudgeThoseOf(folder, kRasters, quick, progress, verdicts));
  if (!fs::exists(folder / "mosaic.mbtiles", gone) || !fs::exists(folder / "report.json", gone)) {
    FileVerdict missing;
    missing.file = folder.filename().string();
    missing.kind = "folder";
    for (const char* name : {"mosaic.mbtiles", "report.json"}) {
      if (!fs::exists(folder / name, gone))
        missing.Add(Severity::kError, std::string(name) + " is missing; a map of ours has it");
    }
    verdicts.push_back(std::move(missing));
  }
  for (FileVerdict& report : reports) verdicts.push_back(std::move(report));
  return verdicts;
}

}  // namespace

Result<std::vector<FileVerdict>> ValidateMap(const fs::path& path, bool quick, Progress& progress) {
  std::error_code gone;
  if (fs::is_directory(path, gone)) return ValidateFolder(path, quick, progress);
  if (!fs::is_regular_file(path, gone))
    return Error{ErrorCode::kNotFound, "There is no file or folder " + path.string() + ".", ""};
  if (!std::ifstream(path))
    return Error{ErrorCode::kIo, path.string() + " cannot be read. Check its permissions.", ""};
  const Validate validate = ValidatorFor(path);
  if (validate == nullptr)
    return Error{ErrorCode::kUnsupportedFormat,
                 path.string() +
                     " is no map that is known here: MBTiles, PMTiles, GeoTIFF, or the folder of a "
                     "map.",
                 ""};
  progress.BeginStage(path.filename().string());
  SKYQUILT_TRY_ASSIGN(FileVerdict verdict, validate(path, quick, progress));
  return std::vector<FileVerdict>{std::move(verdict)};
}

}  // namespace skyquilt::storage
