#include "core/video/films.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/base/try.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/lists/file_kinds.h"
#include "core/flight/lists/sort_files.h"
#include "core/flight/metadata/capture_time.h"
#include "core/flight/remarks/because.h"
#include "core/video/video_file.h"

namespace skyquilt::video {
namespace {

namespace fs = std::filesystem;

std::string Stem(const flight::InputFile& file) {
  return flight::LowerCase(fs::path(file.name).stem().string());
}

// With its folders, without its ending.
std::string PlaceOf(const flight::InputFile& file) {
  return flight::LowerCase(fs::path(file.name).replace_extension().generic_string());
}

using FilesByStem = std::map<std::string, std::vector<flight::InputFile>>;

// Those beside the film come first: cards number their films anew, each in a folder of its own. What lies
// beside another film is that one's.
std::optional<flight::InputFile> SubtitlesOf(const flight::InputFile& film, const FilesByStem& subtitles,
                                             const std::set<std::string>& places_of_films) {
  const auto named = subtitles.find(Stem(film));
  if (named == subtitles.end()) return std::nullopt;
  std::optional<flight::InputFile> elsewhere;
  for (const flight::InputFile& file : named->second) {
    const std::string place = PlaceOf(file);
    if (place == PlaceOf(film)) return file;
    if (!elsewhere && !places_of_films.contains(place)) elsewhere = file;
  }
  return elsewhere;
}

bool IsFilm(const flight::InputFile& file) {
  const auto source = flight::OpenFileBytes(file.path);
  if (!source) return false;  // reading it says why
  const std::vector<std::uint8_t> head = (*source)->ReadUpTo(0, flight::kFilmHeadBytes);
  return flight::LooksLikeFilm({reinterpret_cast<const char*>(head.data()), head.size()});
}

// `film` under a name whose stem no film before it had.
flight::InputFile WithNameOfItsOwn(flight::InputFile film, std::set<std::string>& stems) {
  const fs::path name(film.name);
  for (int number = 2; !stems.insert(Stem(film)).second; ++number) {
    film.name = fmt::format("{}_{}{}", name.stem().string(), number, name.extension().string());
  }
  return film;
}

// From when until when, by the camera's clock, of whatever zone.
struct Filmed {
  flight::UtcTime from, until;
  bool is_by_creation = false;  // which is the end where a camera writes it so
};

// What a film says of when it was taken.
struct FilmClocks {
  std::optional<flight::UtcTime> named, created;
  std::chrono::milliseconds lasts{0};
};

FilmClocks ClocksOf(const flight::InputFile& film) {
  const Result<VideoFile> video = VideoFile::Open(film.path, 1);
  if (!video) return {};  // taking its frames says why
  const VideoFacts& facts = video->facts();
  FilmClocks clocks;
  if (const std::optional<flight::NameTime> named = flight::TimeInName(film.name)) clocks.named = named->time;
  clocks.created = facts.created_at;
  const double lasts_s = std::clamp(facts.duration_s, 0.0, kLongestFilmS);
  clocks.lasts = std::chrono::milliseconds(std::llround(1e3 * lasts_s));
  return clocks;
}

// A time in a film's name is that of its beginning, and its time of creation is so in most cameras. Names
// tell a local clock as a rule and creations UTC, and all frames are tied to a track by one clock: names
// count where each film has one. None where one film would have begun while another was taken: of a clock
// that starts anew with each, or of parts that all bear the time of the first.
std::map<fs::path, Filmed> WhenFilmed(const std::vector<flight::InputFile>& films) {
  std::map<fs::path, FilmClocks> clocks;
  for (const flight::InputFile& film : films) {
    const FilmClocks its = ClocksOf(film);
    if (its.named || its.created) clocks.emplace(film.path, its);
  }
  const bool are_named = std::all_of(clocks.begin(), clocks.end(),
                                     [](const auto& film) { return film.second.named.has_value(); });
  if (!are_named) std::erase_if(clocks, [](const auto& film) { return !film.second.created.has_value(); });
  std::map<fs::path, Filmed> filmed;
  std::vector<Filmed> in_order;
  for (const auto& [path, its] : clocks) {
    const flight::UtcTime from = are_named ? *its.named : *its.created;
    in_order.push_back(filmed.emplace(path, Filmed{from, from + its.lasts, !are_named}).first->second);
  }
  std::sort(in_order.begin(), in_order.end(),
            [](const Filmed& a, const Filmed& b) { return a.from < b.from; });
  const auto rival = std::adjacent_find(
      in_order.begin(), in_order.end(),
      [](const Filmed& a, const Filmed& b) { return b.from + std::chrono::seconds(1) < a.until; });
  return rival == in_order.end() ? filmed : std::map<fs::path, Filmed>();
}

// With the name that says the other time it may have begun at.
flight::Remark TimedByCreation(const flight::InputFile& film, const Filmed& when) {
  const auto civil = [](flight::UtcTime time) {
    const auto second = std::chrono::round<std::chrono::seconds>(time);
    return fmt::gmtime(std::chrono::system_clock::to_time_t(second));
  };
  return {flight::RemarkCode::kFilmTimedByCreation,
          {{"file", film.name},
           {"at", fmt::format("{:%Y-%m-%d %H:%M:%S}", civil(when.from))},
           {"film_s", std::chrono::duration<double>(when.until - when.from).count()},
           {"name", fmt::format("{:%Y%m%d_%H%M%S}{}", civil(when.from - (when.until - when.from)),
                                fs::path(film.name).extension().string())}}};
}

}  // namespace

std::vector<flight::InputFile> FilmsAmong(const std::vector<flight::InputFile>& files) {
  std::vector<flight::InputFile> films;
  std::copy_if(files.begin(), files.end(), std::back_inserter(films), IsFilm);
  return films;
}

Result<FlightFiles> WithFramesOfFilms(const std::vector<flight::InputFile>& files,
                                      const std::vector<flight::InputFile>& films, const fs::path& folder,
                                      const TakeFramesOptions& options, Progress& progress) {
  FlightFiles result;
  FilesByStem subtitles;
  for (const flight::InputFile& file : files) {
    const std::string ending = flight::LowerCase(fs::path(file.name).extension().string());
    if (ending == ".srt" || ending == ".ass") subtitles[Stem(file)].push_back(file);
  }
  progress.BeginStage("frames");
  std::set<fs::path> used;
  std::set<std::string> stems, films_stems, places_of_films;
  std::optional<std::string> without_place;  // the first film of which nothing says where it was taken
  std::vector<flight::InputFile> taken_files;
  std::vector<flight::InputFile> true_films = films;
  if (auto previews = flight::LeaveOutFilmPreviews(true_films))
    result.warnings.push_back(*std::move(previews));
  for (const flight::InputFile& film : films) used.insert(film.path);
  const std::map<fs::path, Filmed> filmed = WhenFilmed(true_films);
  std::vector<flight::Remark> timed_by_creation;
  for (const flight::InputFile& film : true_films) places_of_films.insert(PlaceOf(film));
  for (const flight::InputFile& film : true_films) {
    films_stems.insert(Stem(film));
    const std::optional<flight::InputFile> srt = SubtitlesOf(film, subtitles, places_of_films);
    const auto when = filmed.find(film.path);
    TakeFramesOptions its_options = options;
    if (when != filmed.end()) its_options.began_at = when->second.from;
    Result<TakenFrames> taken = TakeFrames(WithNameOfItsOwn(film, stems), srt, folder, its_options, progress);
    if (!taken && (taken.error().code == ErrorCode::kCancelled || taken.error().code == ErrorCode::kIo))
      return taken.error();
    if (!taken) {
      result.warnings.push_back(flight::WhyOf(taken.error()));
      continue;
    }
    result.sources.push_back(film);
    if (taken->table && srt) {
      used.insert(srt->path);
      result.sources.push_back(*srt);
    }
    if (!taken->table && !without_place) without_place = film.name;
    if (!taken->table && when != filmed.end() && when->second.is_by_creation)
      timed_by_creation.push_back(TimedByCreation(film, when->second));
    result.warnings.insert(result.warnings.end(), taken->warnings.begin(), taken->warnings.end());
    taken_files.insert(taken_files.end(), taken->photos.begin(), taken->photos.end());
    if (taken->table) taken_files.push_back(*taken->table);
  }
  for (const auto& [stem, files_of_stem] : subtitles) {
    if (!without_place || films_stems.contains(stem)) continue;
    const flight::InputFile& file = files_of_stem.front();
    const std::string name =
        fs::path(*without_place).stem().string() + fs::path(file.name).extension().string();
    result.warnings.push_back({flight::RemarkCode::kSubtitlesOfNoFilm,
                               {{"file", file.name}, {"film", *without_place}, {"name", name}}});
  }
  for (const flight::InputFile& file : files) {
    if (!used.contains(file.path)) result.files.push_back(file);
  }
  if (!timed_by_creation.empty() && !flight::SortFiles(result.files).logs.empty())
    std::move(timed_by_creation.begin(), timed_by_creation.end(), std::back_inserter(result.warnings));
  result.files.insert(result.files.end(), taken_files.begin(), taken_files.end());
  return result;
}

}  // namespace skyquilt::video
