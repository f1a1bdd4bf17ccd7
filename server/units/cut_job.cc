#include "server/units/cut_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/scoped_folder.h"
#include "core/base/try.h"
#include "core/pipeline/units/flight_cut.h"
#include "core/pipeline/units/map_units.h"
#include "server/jobs/job_limits.h"
#include "server/jobs/stitch_sandboxed.h"
#include "server/routing/request_log.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"
#include "storage/jobs/unit_inputs.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

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

// Keys of what units leave, where photos and maps lie elsewhere: with their flight they go.
std::string UnitsPrefix(const std::string& flight_id, const std::string& units_of) {
  return storage::FlightPrefix(flight_id) + storage::UnitsFolderName(units_of) + "/";
}

// Below work/, where it is swept once it is of no use.
fs::path UnitsFolder(const storage::DataDir& dir, const std::string& units_of) {
  return dir.Work() / storage::UnitsWorkName(units_of);
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

// The names of the files that units handed in, by the name of the unit's folder.
Result<std::map<std::string, std::set<std::string>>> HandedIn(const WorkerContext& context,
                                                              const std::string& flight_id,
                                                              const std::string& units_of) {
  std::map<std::string, std::set<std::string>> files;
  if (context.blobs.IsFolder()) {
    std::error_code none;  // a folder that is not there has none
    for (auto entry = fs::recursive_directory_iterator(UnitsFolder(context.dir, units_of), none);
         !none && entry != fs::recursive_directory_iterator(); entry.increment(none)) {
      const fs::path& path = entry->path();
      if (entry.depth() == 1) files[path.parent_path().filename().string()].insert(path.filename().string());
    }
    return files;
  }
  const std::string prefix = UnitsPrefix(flight_id, units_of);
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::BlobInfo> listed, context.blobs.List(prefix));
  for (const storage::BlobInfo& blob : listed) {
    const fs::path path = blob.key.substr(prefix.size());
    files[path.parent_path().string()].insert(path.filename().string());
  }
  return files;
}

// The numbers of the first `count` units of a kind that are whole.
Result<std::set<int>> DoneBefore(const WorkerContext& context, const std::string& flight_id,
                                 const std::string& units_of, UnitKind kind, std::size_t count) {
  SKYQUILT_TRY_ASSIGN(const auto files, HandedIn(context, flight_id, units_of));
  std::set<int> done;
  for (int number = 0; number < static_cast<int>(count); ++number) {
    const auto found = files.find(UnitFiles({}).Folder(kind, number).string());
    if (found != files.end() && IsWhole(kind, found->second)) done.insert(number);
  }
  if (!done.empty()) {
    LogEvent(fmt::format("{} of {} parts of flight {} ({}) are there from an attempt before", done.size(),
                         count, flight_id, UnitKindName(kind)));
  }
  return done;
}

// By what placing left: the blocks of the map.
Result<std::int64_t> BlocksIn(const PartsHere& parts) {
  SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::ReadWholeFile(UnitFiles(parts.dir).Shown()));
  SKYQUILT_TRY_ASSIGN(const pipeline::ShownPhotos shown, pipeline::ParseShown(bytes));
  return static_cast<std::int64_t>(shown.of_blocks.size());
}

// The blocks of the map.
Result<std::int64_t> PlaceUnits(WorkerContext& context, const storage::Lease& lease, const CutJob& cut,
                                Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const std::set<int> placed,
                      DoneBefore(context, lease.flight_id, cut.units_of, UnitKind::kPlace, 1));
  if (!placed.empty()) {
    SKYQUILT_TRY_ASSIGN(const PartsHere before,
                        FetchParts(context, lease.flight_id, cut.units_of, UnitKind::kPlace, progress));
    return BlocksIn(before);
  }
  SKYQUILT_TRY(context.units.MakeAs(lease.job_id, SKYQUILT_VERSION));
  SKYQUILT_TRY_ASSIGN(LimitedTask made, TaskOf(context, lease.flight_id, lease.options, {}, progress));
  SKYQUILT_TRY_ASSIGN(PartsHere parts,
                      FetchParts(context, lease.flight_id, cut.units_of, UnitKind::kLook, progress));
  UseParts(std::move(parts), made);
  SKYQUILT_TRY_ASSIGN(fs::path folder, MakeOutFolder(context, cut.units_of, UnitKind::kPlace, 0));
  const ScopedFolder out(std::move(folder));
  made.task.out_dir = out.path();
  made.task.unit = UnitToDo{.kind = UnitKind::kPlace, .looks = cut.looks};
  const StitchedInSandbox done = StitchSandboxed(std::move(made.task), made.limits, progress);
  if (!done.outcome) return done.outcome.error();
  SKYQUILT_TRY(HandIn(context, lease.flight_id, cut.units_of, UnitKind::kPlace, 0, out.path(), progress));
  return done.outcome->blocks;
}

}  // namespace

void RemoveUnits(const WorkerContext& context, const std::string& flight_id, const CutJob& cut) {
  std::error_code ignored;  // what stays is swept
  fs::remove_all(UnitsFolder(context.dir, cut.units_of), ignored);
  if (context.blobs.IsFolder()) return;
  const Result<int> removed = context.blobs.RemoveBelow(UnitsPrefix(flight_id, cut.units_of));
  if (!removed) LogFailure(flight_id, "units", removed.error());  // swept later
}

Result<PartsHere> FetchParts(const WorkerContext& context, const std::string& flight_id,
                             const std::string& units_of, UnitKind kind, Progress& progress) {
  if (context.blobs.IsFolder()) return PartsHere{UnitsFolder(context.dir, units_of), {}};
  const std::string prefix = UnitsPrefix(flight_id, units_of);
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

Result<fs::path> MakeOutFolder(const WorkerContext& context, const std::string& units_of, UnitKind kind,
                               int number) {
  const fs::path folder = UnitFiles(UnitsFolder(context.dir, units_of)).Folder(kind, number);
  const std::string attempts = folder.filename().string() + ".";
  std::vector<fs::path> earlier;
  std::error_code none;  // without an earlier attempt this one begins anew
  for (const auto& entry : fs::directory_iterator(folder.parent_path(), none)) {
    if (entry.path().filename().string().starts_with(attempts)) earlier.push_back(entry.path());
  }
  fs::path own = folder.parent_path() / (attempts + storage::NewId());
  for (const fs::path& attempt : earlier) {
    if (!fs::exists(own, none)) fs::rename(attempt, own, none);
    fs::remove_all(attempt, none);
  }
  std::error_code error;
  fs::create_directories(own, error);
  if (error) return MapNotStored("make " + own.string(), error.value());
  return own;
}

Result<void> HandIn(const WorkerContext& context, const std::string& flight_id, const std::string& units_of,
                    UnitKind kind, int number, const fs::path& made, Progress& progress) {
  const fs::path folder = UnitFiles(UnitsFolder(context.dir, units_of)).Folder(kind, number);
  if (!context.blobs.IsFolder()) {
    return PutProducts(context.blobs, made,
                       UnitsPrefix(flight_id, units_of) + folder.filename().string() + "/", progress);
  }
  std::error_code error;
  fs::rename(made, folder, error);
  if (error == std::errc::directory_not_empty || error == std::errc::file_exists) {
    SKYQUILT_TRY_ASSIGN(auto files, HandedIn(context, flight_id, units_of));
    // An attempt whose end was not heard left the same.
    if (IsWhole(kind, files[folder.filename().string()])) return {};
    fs::remove_all(folder, error);  // a version before made its parts in place, and was cut off
    if (!error) fs::rename(made, folder, error);
  }
  if (error) return MapNotStored("rename " + made.string(), error.value());
  return storage::SyncFolder(folder.parent_path());
}

Result<CutJob> CutOf(const WorkerContext& context, const storage::Lease& lease) {
  CutJob cut;
  if (IsMadeWhole(lease.options)) return cut;
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
  SKYQUILT_TRY_ASSIGN(cut.units_of, context.units.UnitsOf(lease.job_id));
  return cut;
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
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> stored,
                      context.catalogue.ListFiles(lease.flight_id));
  const std::string made_from =
      storage::DigestOf({stored, lease.options, SKYQUILT_VERSION, static_cast<int>(looks)});
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> units_of,
                      context.units.TakeOver(lease, made_from, storage::Now()));
  if (!units_of) return false;
  SKYQUILT_TRY_ASSIGN(const std::set<int> done,
                      DoneBefore(context, lease.flight_id, *units_of, UnitKind::kLook, looks));
  return context.units.Cut(lease, UnitKindName(UnitKind::kLook), static_cast<int>(looks), cut.files,
                           {0.0, kLooked, "check"}, done);
}

Result<bool> PlaceAndCut(WorkerContext& context, const storage::Lease& lease, const CutJob& cut,
                         Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const std::int64_t blocks, PlaceUnits(context, lease, cut, progress));
  // By how it was cut first, not by the options of this worker.
  const std::size_t renders =
      std::min<std::size_t>(pipeline::UnitsOf(static_cast<std::size_t>(cut.looks), pipeline::kLooksPerRender),
                            static_cast<std::size_t>(std::max<std::int64_t>(1, blocks)));
  SKYQUILT_TRY_ASSIGN(const std::set<int> done,
                      DoneBefore(context, lease.flight_id, cut.units_of, UnitKind::kRender, renders));
  return context.units.Cut(lease, UnitKindName(UnitKind::kRender), static_cast<int>(renders), blocks,
                           {kPlaced, kRendered, "render"}, done);
}

}  // namespace skyquilt::server
