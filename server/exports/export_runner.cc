#include "server/exports/export_runner.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <system_error>

#include "api/json/json_codec.h"
#include "core/base/scoped_folder.h"
#include "core/base/try.h"
#include "server/exports/export_sandboxed.h"
#include "server/reports/map_picture.h"
#include "server/reports/print_pdf.h"
#include "server/reports/report_page.h"
#include "server/routing/request_log.h"
#include "storage/exports/custom/export_map.h"
#include "storage/files/publish_file.h"
#include "storage/folder/sweep.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using storage::MapExport;

constexpr std::chrono::milliseconds kExportPause{500};
constexpr std::chrono::seconds kBeatEvery{1};
// The catalogue is asked at once for what came in here, and now and then for what was left or others could
// not make.
constexpr std::chrono::seconds kAskEvery{10};
constexpr double kShareOfPicture = 0.5;  // of the work on a report; printing says nothing of how far it is

Error Replaced() {
  return {ErrorCode::kConflict, "The map was replaced before its export began. Ask for the export again."};
}

// A second name for a product of the map, so that it stays although the map is replaced meanwhile.
Result<void> Hold(storage::BlobStore& blobs, const std::string& prefix, const char* name,
                  const fs::path& folder) {
  const Result<storage::LocalBlob> product = blobs.Local(prefix + name);
  if (!product) return product.error().code == ErrorCode::kNotFound ? Replaced() : product.error();
  if (link(product->path.c_str(), (folder / name).c_str()) == 0) return {};
  return errno == ENOENT ? Replaced() : storage::FileError("cannot link", product->path, errno);
}

// What an export will hardly take while it is made: twice the map, and three times where it is warped, for
// its blocks lie beside the file meanwhile. Values are floats, three times over: on the map's pixels, in the
// other system, in the file.
Result<std::int64_t> ExpectedBytes(const fs::path& map_dir, const storage::ExportRequest& request) {
  constexpr std::int64_t kOfReport = std::int64_t{256} << 20;
  constexpr double kOfValue = 14.0;
  if (request.format == storage::ExportFormat::kReport) return kOfReport;
  if (request.IsOfValues()) {
    SKYQUILT_TRY_ASSIGN(const double pixels, storage::PixelsOfExport(map_dir, request));
    return static_cast<std::int64_t>(kOfValue * pixels);
  }
  std::int64_t bytes = 0;
  for (const char* name : {"mosaic.mbtiles", "mosaic.tif"}) {
    std::error_code missing;
    const std::uintmax_t size = fs::file_size(map_dir / name, missing);
    if (!missing) bytes = std::max(bytes, static_cast<std::int64_t>(size));
  }
  const bool is_warped = request.format == storage::ExportFormat::kGeotiff && !storage::IsAsStored(request);
  return (is_warped ? 3 : 2) * bytes;
}

// From the pixels that the sandboxed process left, the page about the map, printed in a folder that it never
// saw. The bytes of the file.
Result<std::int64_t> PrintReport(const fs::path& map_dir, const fs::path& pixels_file, const fs::path& folder,
                                 const fs::path& pdf, const std::string& name,
                                 const std::function<bool()>& go_on) {
  std::error_code error;
  const std::uintmax_t left = fs::file_size(pixels_file, error);
  if (error || left > kMaxMapPixelBytes)
    return Error{ErrorCode::kCorrupt, "The report's picture of the map is damaged.", pixels_file.string()};
  SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::ReadWholeFile(pixels_file));
  SKYQUILT_TRY_ASSIGN(const MapPixels pixels, ParseMapPixels(bytes));
  SKYQUILT_TRY_ASSIGN(const std::string report, storage::ReadWholeFile(map_dir / "report.json"));
  const std::string today = api::FormatTime(storage::Now()).substr(0, 10);
  SKYQUILT_TRY_ASSIGN(const std::string page, ReportPage(report, EncodeMapPicture(pixels), today, name));
  if (!fs::create_directory(folder, error)) return storage::FileError("cannot make", folder, error.value());
  const fs::path html = folder / "report.html";
  SKYQUILT_TRY(storage::WriteFileAtomically(html, page));
  const Result<void> printed = PrintPdf(html, pdf, folder, go_on);
  if (!printed) return ReportNotPrinted(printed.error());
  const std::uintmax_t size = fs::file_size(pdf, error);
  if (error) return storage::FileError("cannot read", pdf, error.value());
  return static_cast<std::int64_t>(size);
}

// What an export reads of the map beside its tiles, where it is there; null: nothing.
const char* FileBesideTiles(const storage::ExportRequest& request) {
  if (request.IsOfValues()) return "bands.tif";
  const bool is_copied =
      request.format == storage::ExportFormat::kGeotiff && !request.boundary && storage::IsAsStored(request);
  return is_copied ? "mosaic.tif" : nullptr;
}

}  // namespace

ExportRunner::ExportRunner(api::Service& service) : service_(service), thread_([this] { Run(); }) {}

void ExportRunner::Run() {
  auto asked = std::chrono::steady_clock::now() - kAskEvery;
  bool made_one = false;    // others may wait behind it
  bool is_failing = false;  // a catalogue that is away is asked no more often than one without news
  while (!thread_.IsEnded()) {
    Result<std::optional<MapExport>> claimed = std::optional<MapExport>();
    const auto now = std::chrono::steady_clock::now();
    const bool asks = made_one || now - asked >= kAskEvery || (service_.exports.HasNew() && !is_failing);
    if (asks && service_.storage_in_place()) {
      claimed = service_.exports.Claim(storage::Now(), !service_.db.IsShared() || service_.prints_pdf());
      asked = now;
      is_failing = !claimed;
    }
    made_one = claimed && claimed->has_value();
    if (!claimed) LogFailure("-", "exports", claimed.error());
    if (claimed && *claimed) {
      Make(**claimed);
      continue;
    }
    thread_.Rest(kExportPause);
  }
}

void ExportRunner::Make(const MapExport& claimed) {
  const storage::DataDir& dir = service_.store.dir();
  const ScopedFolder staging(dir.Incoming() / dir.NewTemporaryName(storage::kExportKind));
  std::error_code unmade;
  fs::create_directory(staging.path(), unmade);
  const auto begun = std::chrono::steady_clock::now();
  const Result<std::int64_t> made = unmade ? storage::FileError("cannot make", staging.path(), unmade.value())
                                           : MakeWhateverHappens(claimed, staging.path());
  Result<bool> told = false;
  if (made) {
    told = service_.exports.Succeed(claimed, *made, storage::Now());
    // Nobody's by now: it was removed while its file came into place.
    if (told && !*told) (void)service_.store.blobs().Remove(storage::ExportKey(claimed)).ok();
    LogEvent(fmt::format("export {}: {} bytes in {:.1f} s", claimed.id, *made,
                         std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count()));
  } else if (made.error().code == ErrorCode::kCancelled) {
    told = service_.exports.GiveBack(claimed);  // one that was removed is nobody's
  } else {
    LogFailure(claimed.id, "export", made.error());
    told = service_.exports.Fail(claimed, made.error(), storage::Now());
  }
  if (!told) LogFailure(claimed.id, "export", told.error());
}

// What this process is out of ends one export, not the server.
Result<std::int64_t> ExportRunner::MakeWhateverHappens(const MapExport& claimed, const fs::path& staging) {
  try {
    return MakeIn(claimed, staging);
  } catch (const std::exception& thrown) {
    return Error{ErrorCode::kOutOfSpace, "The server ran out of memory for this export. Try again later.",
                 thrown.what()};
  }
}

Result<std::int64_t> ExportRunner::MakeIn(const MapExport& claimed, const fs::path& staging) {
  SKYQUILT_TRY_ASSIGN(const storage::ExportRequest request, storage::ParseExportRequest(claimed.request));
  const fs::path map_dir = staging / "map", work_dir = staging / "work";
  std::error_code unmade;
  if (!fs::create_directory(map_dir, unmade) || !fs::create_directory(work_dir, unmade))
    return storage::FileError("cannot make", staging, unmade.value());
  storage::BlobStore& blobs = service_.store.blobs();
  const std::string prefix = storage::RevisionPrefix(claimed.flight_id, claimed.revision);
  // A map without it is exported all the same: from its tiles, from its colours. The tiles last: while they
  // are there, what was not there before was not removed meanwhile.
  if (const char* const more = FileBesideTiles(request)) {
    const Result<void> held = Hold(blobs, prefix, more, map_dir);
    if (!held && held.error().code != ErrorCode::kConflict) return held.error();
  }
  SKYQUILT_TRY(Hold(blobs, prefix, "report.json", map_dir));
  SKYQUILT_TRY(Hold(blobs, prefix, "mosaic.mbtiles", map_dir));
  const ExportLimits limits;
  SKYQUILT_TRY_ASSIGN(const std::int64_t expected_bytes, ExpectedBytes(map_dir, request));
  SKYQUILT_TRY_ASSIGN(const std::int64_t free_bytes, FreeBytes(staging));
  if (free_bytes < limits.keep_free_bytes + expected_bytes)
    return Error{
        ErrorCode::kOutOfSpace,
        "The server's disk has no room for this export. Free some space, or ask for a smaller area."};
  ExportTask task;
  task.map_dir = map_dir;
  task.work_dir = work_dir;
  const std::string file_name = std::string("export.") + storage::EndingOf(request.format);
  const bool is_report = request.format == storage::ExportFormat::kReport;
  task.out_name = is_report ? "pixels" : file_name;
  task.request = claimed.request;
  task.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / 2);
  auto beaten = std::chrono::steady_clock::time_point();
  const auto go_on = [&](double fraction) {
    if (thread_.IsEnded()) return false;
    const auto now = std::chrono::steady_clock::now();
    if (now - beaten < kBeatEvery) return true;
    beaten = now;
    // A catalogue that is away for a moment stops nothing: the lease is longer.
    const Result<bool> is_ours = service_.exports.Heartbeat(claimed, fraction, storage::Now());
    return !is_ours || *is_ours;
  };
  SKYQUILT_TRY_ASSIGN(std::int64_t bytes, ExportSandboxed(task, limits, go_on));
  if (!is_report) {
    SKYQUILT_TRY(Store(claimed, work_dir / file_name));
    return bytes;
  }
  const fs::path folder = staging / "print";
  SKYQUILT_TRY_ASSIGN(bytes, PrintReport(map_dir, work_dir / task.out_name, folder, folder / file_name,
                                         request.name, [&] { return go_on(kShareOfPicture); }));
  SKYQUILT_TRY(Store(claimed, folder / file_name));
  return bytes;
}

Result<void> ExportRunner::Store(const MapExport& claimed, const fs::path& made) {
  storage::BlobStore& blobs = service_.store.blobs();
  const std::string key = storage::ExportKey(claimed);
  if (!blobs.IsFolder()) return blobs.Put(key, made);
  const fs::path path = blobs.FolderOf(key);
  std::error_code error;
  // One level only: a flight that is gone is not made anew.
  fs::create_directory(path.parent_path(), error);
  if (error) return storage::FileError("cannot make", path.parent_path(), error.value());
  return storage::PublishFile(made, path);
}

Result<void> RecoverExports(api::Service& service) {
  // Where several servers share the catalogue, the lease says whose server has died.
  if (!service.db.IsShared()) SKYQUILT_TRY(service.exports.TakeUpAfterRestart());
  if (!service.store.blobs().IsFolder()) return {};
  SKYQUILT_TRY_ASSIGN(
      const std::vector<std::string> moved,
      storage::SweepExports(service.store.dir(), service.catalogue, service.exports, storage::Now()));
  for (const std::string& line : moved) LogEvent(line);
  return {};
}

}  // namespace skyquilt::server
