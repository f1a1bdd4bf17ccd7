#include "server/units/cut_job.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "core/pipeline/units/flight_cut.h"
#include "core/pipeline/units/shown_photos.h"
#include "server/jobs/job_task.h"
#include "server/jobs/stitch_apart.h"
#include "server/routing/request_log.h"
#include "storage/tilesets/publish_file.h"

namespace skyquilt::server {
namespace {

// Shares of a large flight's time on one worker; more workers shorten the first and the third.
constexpr double kLooked = 0.30;
constexpr double kPlaced = 0.50;
constexpr double kRendered = 0.90;

const storage::UnitCount* CountOf(const std::vector<storage::UnitCount>& counts, UnitKind kind) {
  const auto found = std::find_if(counts.begin(), counts.end(), [&](const storage::UnitCount& count) {
    return count.kind == UnitKindName(kind);
  });
  return found == counts.end() ? nullptr : &*found;
}

bool IsNameOfFilm(const std::string& name) {
  std::string end = std::filesystem::path(name).extension().string();
  std::transform(end.begin(), end.end(), end.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::array kEnds = {".mp4", ".mov", ".m4v", ".avi", ".mkv", ".ts", ".mts"};
  return std::find(kEnds.begin(), kEnds.end(), end) != kEnds.end();
}

// Keys of what units leave, where photos and maps lie elsewhere: with their flight they go.
std::string UnitsPrefix(const std::string& flight_id, const std::string& job_id) {
  return storage::FlightPrefix(flight_id) + storage::UnitsFolderName(job_id) + "/";
}

Error CannotStorePart(const std::error_code& error) {
  return {ErrorCode::kIo, "The server could not store a part of the map.", error.message()};
}

// A flight that has a map is changed, not made anew; frames of a film are known only once they are taken.
Result<bool> ShouldCut(const WorkerContext& context, const storage::Lease& lease, int& files) {
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> all,
                      context.catalogue.ListFiles(lease.flight_id));
  files = static_cast<int>(all.size());
  if (context.cut_above_files == 0 || files <= context.cut_above_files) return false;
  if (std::any_of(all.begin(), all.end(), [](const auto& file) { return IsNameOfFilm(file.name); }))
    return false;
  SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> revisions,
                      context.catalogue.Revisions(lease.flight_id));
  return revisions.empty();
}

Result<CutJob> Find(const WorkerContext& context, const storage::Lease& lease) {
  CutJob cut;
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::UnitCount> counts, context.units.Of(lease.job_id));
  const storage::UnitCount* looks = CountOf(counts, UnitKind::kLook);
  if (looks == nullptr) {
    SKYQUILT_TRY_ASSIGN(const bool is_cut, ShouldCut(context, lease, cut.files));
    if (is_cut) cut.step = CutStep::kLook;
    return cut;
  }
  cut.files = static_cast<int>(looks->items);
  cut.looks = looks->count;
  const storage::UnitCount* renders = CountOf(counts, UnitKind::kRender);
  cut.step = renders == nullptr ? CutStep::kPlace : CutStep::kPutTogether;
  if (renders != nullptr) cut.renders = renders->count;
  return cut;
}

}  // namespace

std::filesystem::path UnitsFolder(const storage::DataDir& dir, const std::string& job_id) {
  return dir.Work() / (job_id + "-units");
}

void RemoveUnits(const WorkerContext& context, const storage::Lease& lease) {
  std::error_code ignored;  // what stays is swept at the next start
  std::filesystem::remove_all(UnitsFolder(context.dir, lease.job_id), ignored);
  if (context.blobs.IsFolder()) return;
  const Result<int> removed = context.blobs.RemoveBelow(UnitsPrefix(lease.flight_id, lease.job_id));
  if (!removed) LogFailure(lease.job_id, "units", removed.error().message);  // swept later
}

Result<PartsHere> FetchParts(const WorkerContext& context, const storage::Lease& lease, UnitKind kind,
                             Progress& progress) {
  if (context.blobs.IsFolder()) return PartsHere{UnitsFolder(context.dir, lease.job_id), {}};
  const std::string prefix = UnitsPrefix(lease.flight_id, lease.job_id);
  PartsHere here{context.blobs.FolderOf(prefix), {}};
  // Placing needs what was found; rendering and what comes after it the facts, not what was found.
  const UnitKind first = kind == UnitKind::kLook ? UnitKind::kLook : UnitKind::kPlace;
  for (const UnitKind wanted : {first, kind}) {
    SKYQUILT_TRY_ASSIGN(FilesInUse parts,
                        FetchBelow(context.blobs, prefix + UnitKindName(wanted) + "-", progress));
    here.in_use.insert(here.in_use.end(), parts.begin(), parts.end());
    if (first == kind) break;
  }
  return here;
}

void UseParts(PartsHere parts, LimitedTask& made) {
  made.task.units_dir = std::move(parts.dir);
  made.in_use.insert(made.in_use.end(), parts.in_use.begin(), parts.in_use.end());
}

Result<ShareOfFiles> ShownIn(const PartsHere& parts, const storage::UnitLease& unit) {
  SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::ReadWholeFile(UnitFiles(parts.dir).Shown()));
  SKYQUILT_TRY_ASSIGN(const pipeline::ShownPhotos shown, pipeline::ParseShown(bytes));
  ShareOfFiles share;
  share.names = shown.NamesIn(pipeline::RangeOf(static_cast<std::size_t>(unit.number),
                                                static_cast<std::size_t>(unit.count),
                                                static_cast<std::size_t>(unit.items)));
  return share;
}

Result<std::filesystem::path> MakeOutFolder(const WorkerContext& context, const std::string& job_id,
                                            UnitKind kind, int number) {
  std::filesystem::path folder = UnitFiles(UnitsFolder(context.dir, job_id)).Folder(kind, number);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return CannotStorePart(error);
  return folder;
}

Result<void> HandIn(const WorkerContext& context, const std::string& flight_id, const std::string& job_id,
                    UnitKind kind, int number, Progress& progress) {
  if (context.blobs.IsFolder()) return {};
  const std::filesystem::path folder = UnitFiles(UnitsFolder(context.dir, job_id)).Folder(kind, number);
  SKYQUILT_TRY(PutProducts(context.blobs, folder,
                           UnitsPrefix(flight_id, job_id) + folder.filename().string() + "/", progress));
  std::error_code error;
  std::filesystem::remove_all(folder, error);
  if (error) return CannotStorePart(error);
  return {};
}

CutJob CutOf(const WorkerContext& context, const storage::Lease& lease) {
  if (IsImport(lease.options)) return {};
  const Result<CutJob> cut = Find(context, lease);
  if (cut) return *cut;
  LogFailure(lease.job_id, "cut", cut.error().message + " " + cut.error().detail);
  return {};
}

ProgressSpan ProgressOf(CutStep step) {
  switch (step) {
    case CutStep::kLook:
      return {0.0, 0.0};
    case CutStep::kPlace:
      return {kLooked, kPlaced};
    case CutStep::kPutTogether:
      return {kRendered, 1.0};
    case CutStep::kWhole:
      break;
  }
  return {};
}

Result<bool> CutIntoLooks(WorkerContext& context, const storage::Lease& lease, const CutJob& cut) {
  const std::size_t files = static_cast<std::size_t>(cut.files);
  const std::size_t looks = pipeline::UnitsOf(files, static_cast<std::size_t>(context.files_per_unit));
  return context.units.Cut(lease, UnitKindName(UnitKind::kLook), static_cast<int>(looks), cut.files,
                           {0.0, kLooked, "check"});
}

Result<bool> PlaceAndCut(WorkerContext& context, const storage::Lease& lease, const CutJob& cut,
                         Progress& progress) {
  SKYQUILT_TRY_ASSIGN(LimitedTask made, TaskOf(context, lease.flight_id, lease.options, {}, progress));
  SKYQUILT_TRY_ASSIGN(PartsHere parts, FetchParts(context, lease, UnitKind::kLook, progress));
  UseParts(std::move(parts), made);
  SKYQUILT_TRY_ASSIGN(made.task.out_dir, MakeOutFolder(context, lease.job_id, UnitKind::kPlace, 0));
  made.task.unit = UnitToDo{.kind = UnitKind::kPlace, .looks = cut.looks};
  const StitchedApart placed = StitchApart(std::move(made.task), made.limits, progress);
  if (!placed.outcome) return placed.outcome.error();
  SKYQUILT_TRY(HandIn(context, lease.flight_id, lease.job_id, UnitKind::kPlace, 0, progress));
  const auto files = static_cast<std::size_t>(cut.files);
  const std::size_t renders = std::min<std::size_t>(
      pipeline::UnitsOf(files, pipeline::kLooksPerRender * static_cast<std::size_t>(context.files_per_unit)),
      static_cast<std::size_t>(std::max<std::int64_t>(1, placed.outcome->blocks)));
  return context.units.Cut(lease, UnitKindName(UnitKind::kRender), static_cast<int>(renders),
                           placed.outcome->blocks, {kPlaced, kRendered, "render"});
}

}  // namespace skyquilt::server
