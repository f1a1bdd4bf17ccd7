#include "core/flight/read_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include "core/base/parallel_for.h"
#include "core/base/text/file_names.h"
#include "core/base/text/printable.h"
#include "core/base/try.h"
#include "core/flight/aside/copies.h"
#include "core/flight/aside/one_camera.h"
#include "core/flight/lists/file_kinds.h"
#include "core/flight/lists/sort_files.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/metadata/capture_time.h"
#include "core/flight/photos/correct_heights.h"
#include "core/flight/photos/retagged.h"
#include "core/flight/photos/sidecars.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {
namespace {

// Names are how a person and a log speak of a photo, so that each must be one photo's own.
void MakeNamesUnique(std::vector<InputFile>& files) {
  std::set<std::string> taken;
  std::map<std::string, int> copies;
  for (InputFile& file : files) {
    const std::string original = file.name;
    while (!taken.insert(file.name).second)
      file.name = NumberedName(original, std::to_string(++copies.try_emplace(original, 1).first->second));
  }
}

std::vector<std::optional<Result<Photo>>> ReadAll(const std::vector<InputFile>& files, int threads,
                                                  Progress& progress) {
  std::vector<std::optional<Result<Photo>>> read(files.size());
  std::mutex mutex;
  std::size_t done = 0;
  ParallelFor(files.size(), threads, [&](std::size_t i) {
    if (progress.IsCancelled()) return;
    read[i] = ReadPhoto(files[i]);
    const std::lock_guard lock(mutex);
    ++done;
    progress.Report(static_cast<double>(done) / static_cast<double>(files.size()),
                    fmt::format("{} of {} files read", done, files.size()));
  });
  return read;
}

// What a log or list says, its doubts to the notes; what cannot be read is a warning, which names its file.
template <typename List>
void KeepList(Result<List> list, std::vector<List>& lists, std::vector<Remark>& warnings,
              std::vector<Remark>& notes) {
  if (!list) {
    warnings.push_back({RemarkCode::kFileNotRead, {{"why", WhyOf(list.error())}}});
    return;
  }
  for (const Remark& warning : list->warnings)
    notes.push_back({RemarkCode::kOfFile, {{"file", list->file_name}, {"said", warning}}});
  lists.push_back(*std::move(list));
}

// One after the other: a long log takes the memory it is allowed only once.
void ReadLogs(const SortedFiles& files, Flight& flight, Progress& progress) {
  flight.warnings.insert(flight.warnings.end(), files.refused.begin(), files.refused.end());
  std::vector<Remark> notes;
  const auto duplicate_of = FindDuplicates(files.logs);
  for (std::size_t i = 0; i < files.logs.size(); ++i) {
    const InputFile& file = files.logs[i];
    if (progress.IsCancelled()) continue;
    if (duplicate_of[i]) {
      notes.push_back(
          {RemarkCode::kSameFile, {{"file", file.name}, {"other", files.logs[*duplicate_of[i]].name}}});
      continue;
    }
    progress.Report(0.0, fmt::format("reading the log {}", file.name));
    KeepList(ReadLog(file), flight.logs, flight.warnings, notes);
  }
  for (const InputFile& file : files.gcp_lists)
    KeepList(ReadWrittenGcpList(file), flight.gcp_lists, flight.warnings, notes);
  for (const InputFile& file : files.reflectance_lists)
    KeepList(ReadReflectanceList(file), flight.reflectance_lists, flight.warnings, notes);
  // What cannot be read stands above what was read and is only doubted.
  if (files.unused) flight.warnings.push_back(*files.unused);
  flight.warnings.insert(flight.warnings.end(), notes.begin(), notes.end());
  const auto by_name = [](const auto& a, const auto& b) { return a.file_name < b.file_name; };
  std::stable_sort(flight.logs.begin(), flight.logs.end(), by_name);
  std::stable_sort(flight.gcp_lists.begin(), flight.gcp_lists.end(), by_name);
  std::stable_sort(flight.reflectance_lists.begin(), flight.reflectance_lists.end(), by_name);
  for (const InputFile& file : files.elevation_models) flight.elevation_models.push_back(file.name);
  std::sort(flight.elevation_models.begin(), flight.elevation_models.end());
  if (flight.elevation_models.size() > 1) {
    flight.warnings.push_back(
        {RemarkCode::kElevationModels,
         {{"models", flight.elevation_models.size()}, {"file", flight.elevation_models.front()}}});
  }
}

// How much is said at most of what was found on reading the photos: the notes of one flight are of few kinds,
// but for those that carry a number of each photo.
constexpr std::size_t kMaxKindsOfNotes = 8;

// What was doubted or could not be used on reading the photos: each kind once, the most frequent first, with
// the first photo that it is said of.
void TellNotes(Flight& flight) {
  struct Told {
    Remark note;
    std::string first_photo;
    std::size_t photos = 0;
  };
  std::vector<Told> told;
  std::map<std::string, std::size_t> at;
  for (const Photo& photo : flight.photos) {
    for (const Remark& note : photo.notes) {
      const auto [found, is_new] = at.try_emplace(InWords(note), told.size());
      if (is_new) told.push_back({note, photo.name, 0});
      ++told[found->second].photos;
    }
  }
  std::stable_sort(told.begin(), told.end(),
                   [](const Told& a, const Told& b) { return a.photos > b.photos; });
  for (std::size_t k = 0; k < std::min(told.size(), kMaxKindsOfNotes); ++k) {
    const Told& one = told[k];
    if (one.photos == 1) {
      flight.warnings.push_back({RemarkCode::kOfPhoto, {{"photo", one.first_photo}, {"said", one.note}}});
      continue;
    }
    flight.warnings.push_back({RemarkCode::kOfPhotos,
                               {{"photos", one.photos},
                                {"total", flight.photos.size()},
                                {"photo", one.first_photo},
                                {"said", one.note}}});
  }
  if (told.size() > kMaxKindsOfNotes) {
    flight.warnings.push_back({RemarkCode::kMoreOfPhotos, {{"remarks", told.size() - kMaxKindsOfNotes}}});
  }
}

void WarnAboutFlight(std::ptrdiff_t timed_by_name, Flight& flight) {
  const auto count = [&](auto predicate) {
    return std::count_if(flight.photos.begin(), flight.photos.end(), predicate);
  };
  const auto total = static_cast<std::ptrdiff_t>(flight.photos.size());
  const auto warn = [&](std::ptrdiff_t photos, RemarkCode what) {
    if (photos > 0) flight.warnings.push_back({what, {{"photos", photos}, {"total", total}}});
  };
  if (flight.logs.empty()) {
    warn(count([](const Photo& p) { return !p.position; }), RemarkCode::kPhotosWithoutPosition);
  }
  warn(timed_by_name, RemarkCode::kPhotosTimedByName);
  warn(count([](const Photo& p) { return !p.captured_at; }), RemarkCode::kPhotosWithoutTime);
  const auto local = count([](const Photo& p) { return p.captured_at && p.captured_at_is_local; });
  if (local > 0 && local < count([](const Photo& p) { return p.captured_at.has_value(); })) {
    warn(local, RemarkCode::kPhotosOfUnknownZone);
  }
  TellNotes(flight);
}

}  // namespace

Result<Flight> ReadFlight(const std::vector<InputFile>& files, int threads, Progress& progress) {
  if (files.empty()) {
    return Because(ErrorCode::kInvalidArgument, RemarkCode::kFailNoFiles);
  }
  progress.BeginStage("read");
  std::vector<InputFile> named = files;
  MakeNamesUnique(named);
  const SortedFiles sorted = SortFiles(named);
  const std::vector<InputFile>& candidates = sorted.photos;
  Flight flight;
  ReadLogs(sorted, flight, progress);
  auto read = ReadAll(candidates, threads, progress);
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "Reading the photos was cancelled.", ""};
  const auto duplicate_of = FindDuplicates(candidates);

  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Result<Photo>& photo = *read[i];
    if (!photo) {
      flight.left_out.push_back({candidates[i].name, photo.error().code, WhyOf(photo.error())});
    } else if (duplicate_of[i]) {
      flight.left_out.push_back(
          LeftAside(candidates[i].name, Aside::kSameBytes, candidates[*duplicate_of[i]].name));
    } else {
      flight.photos.push_back(std::move(*photo));
    }
  }
  TakeZoneOfFlight(flight.photos);
  TakePositionsFromSidecars(sorted.sidecars, flight.photos, flight.warnings);
  LeaveOutRetagged(flight.photos, flight.left_out);
  LeaveOutCopies(flight.photos, flight.left_out);
  std::vector<InputFile> films = sorted.films;
  if (auto previews = LeaveOutFilmPreviews(films)) flight.warnings.push_back(*std::move(previews));
  for (const InputFile& film : films) {
    flight.films.push_back(film.name);
    flight.warnings.push_back({RemarkCode::kFilm, {{"file", film.name}}});
  }
  const int timed_by_name = TakeTimesFromNames(flight.photos);
  std::sort(flight.photos.begin(), flight.photos.end(), ComesBefore);
  KeepOneCamera(flight);
  TakeCorrectedHeights(flight.photos, flight.warnings);
  DropAltitudesOfZero(flight.photos, flight.warnings);
  std::sort(flight.left_out.begin(), flight.left_out.end(),
            [](const LeftOutPhoto& a, const LeftOutPhoto& b) { return a.name < b.name; });
  WarnAboutFlight(timed_by_name, flight);
  progress.Report(1.0, fmt::format("{} and {} read", Counted(flight.photos.size(), "photo"),
                                   Counted(flight.logs.size(), "log")));
  return flight;
}

namespace {

namespace fs = std::filesystem;

Result<std::vector<fs::path>> WalkFolder(const fs::path& folder, const TellsDenied& tells_denied) {
  std::error_code error;
  if (tells_denied && IsDenied(folder)) tells_denied(folder);
  fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error);
  std::vector<fs::path> paths;
  while (!error && it != fs::recursive_directory_iterator()) {
    std::error_code ignored_kind;  // a file that vanished is no file
    if (IsOfPrograms(it->path().filename().string())) {
      if (it->is_directory(ignored_kind)) it.disable_recursion_pending();
    } else if (!it->is_directory(ignored_kind)) {
      paths.push_back(it->path());  // links to nothing and pipes too: reading them says what is wrong
    } else if (tells_denied && !it->is_symlink(ignored_kind) && IsDenied(it->path())) {
      tells_denied(it->path());
    }
    it.increment(error);
  }
  if (error) {
    return Error{ErrorCode::kIo,
                 "The folder " + folder.string() + " cannot be read: " + error.message() + ".", ""};
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace

bool IsDenied(const fs::path& folder) {
  std::error_code error;
  const fs::directory_iterator opened(folder, error);
  return error == std::errc::permission_denied;
}

Result<std::vector<InputFile>> ListInputFiles(const std::vector<fs::path>& paths,
                                              const PassesOver& passes_over,
                                              const TellsDenied& tells_denied) {
  std::vector<fs::path> found;
  for (const fs::path& path : paths) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status))
      return Error{ErrorCode::kNotFound, "There is no file or folder " + path.string() + ".", ""};
    if (!fs::is_directory(status)) {
      found.push_back(path);
    } else {
      SKYQUILT_TRY_ASSIGN(std::vector<fs::path> walked, WalkFolder(path, tells_denied));
      if (passes_over) std::erase_if(walked, [&](const fs::path& file) { return passes_over(file, path); });
      found.insert(found.end(), walked.begin(), walked.end());
    }
  }
  std::vector<InputFile> files;
  std::vector<std::string> whole_paths;  // "./a.jpg" too has a folder of a name
  std::set<fs::path> seen;
  for (const fs::path& path : found) {
    std::error_code gone;
    fs::path whole = fs::absolute(path, gone);  // what is remembered of a map is asked from any folder
    if (gone) whole = path;
    const fs::path normal = whole.lexically_normal();
    if (!seen.insert(normal).second) continue;  // given twice
    whole_paths.push_back(normal.generic_string());
    files.push_back({"", std::move(whole)});
  }
  std::vector<std::string> names = NamesApart(whole_paths);
  for (std::size_t i = 0; i < files.size(); ++i) files[i].name = std::move(names[i]);
  return files;
}

}  // namespace skyquilt::flight
