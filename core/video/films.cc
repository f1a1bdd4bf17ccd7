#include "core/video/films.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "core/base/try.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/lists/file_kinds.h"
#include "core/flight/remarks/because.h"
#include "core/video/video_file.h"

namespace skyquilt::video {
namespace {

namespace fs = std::filesystem;

std::string Stem(const flight::InputFile& file) {
  return flight::LowerCase(fs::path(file.name).stem().string());
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
  std::map<std::string, flight::InputFile> subtitles;
  for (const flight::InputFile& file : files) {
    const std::string ending = flight::LowerCase(fs::path(file.name).extension().string());
    if (ending == ".srt" || ending == ".ass") subtitles.emplace(Stem(file), file);
  }
  progress.BeginStage("frames");
  std::set<fs::path> used;
  std::set<std::string> stems, films_stems;
  std::optional<std::string> without_place;  // the first film of which nothing says where it was taken
  std::vector<flight::InputFile> taken_files;
  for (const flight::InputFile& film : films) {
    films_stems.insert(Stem(film));
    const auto beside = subtitles.find(Stem(film));
    const std::optional<flight::InputFile> srt =
        beside == subtitles.end() ? std::nullopt : std::optional(beside->second);
    Result<TakenFrames> taken = TakeFrames(WithNameOfItsOwn(film, stems), srt, folder, options, progress);
    if (!taken && (taken.error().code == ErrorCode::kCancelled || taken.error().code == ErrorCode::kIo))
      return taken.error();
    used.insert(film.path);
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
    result.warnings.insert(result.warnings.end(), taken->warnings.begin(), taken->warnings.end());
    taken_files.insert(taken_files.end(), taken->photos.begin(), taken->photos.end());
    if (taken->table) taken_files.push_back(*taken->table);
  }
  for (const auto& [stem, file] : subtitles) {
    if (!without_place || films_stems.contains(stem)) continue;
    const std::string name =
        fs::path(*without_place).stem().string() + fs::path(file.name).extension().string();
    result.warnings.push_back({flight::RemarkCode::kSubtitlesOfNoFilm,
                               {{"file", file.name}, {"film", *without_place}, {"name", name}}});
  }
  for (const flight::InputFile& file : files) {
    if (!used.contains(file.path)) result.files.push_back(file);
  }
  result.files.insert(result.files.end(), taken_files.begin(), taken_files.end());
  return result;
}

}  // namespace skyquilt::video
