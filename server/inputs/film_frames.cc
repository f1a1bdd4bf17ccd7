#include "server/inputs/film_frames.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSourcesFile = "frames.json";

Result<void> CheckIsOurs(const fs::path& folder) {
  std::error_code none;  // a folder that is not there is made
  if (!fs::exists(folder, none) || fs::is_empty(folder, none) || fs::exists(folder / kSourcesFile, none))
    return {};
  return Error{ErrorCode::kConflict,
               folder.string() +
                   " holds other files; frames of the films would go there. Nothing was "
                   "changed. Choose another folder with -o."};
}

Result<void> WriteSources(const fs::path& folder, const std::vector<flight::InputFile>& sources) {
  nlohmann::json list = nlohmann::json::array();
  for (const flight::InputFile& source : sources) {
    SKYQUILT_TRY_ASSIGN(const Digest digest, DigestOfFile(source.path));
    list.push_back({{"name", source.name},
                    {"path", fs::absolute(source.path).string()},
                    {"digest", std::vector<int>(digest.begin(), digest.end())}});
  }
  return storage::WriteFileAtomically(folder / kSourcesFile, JsonText(list, 1));
}

std::optional<FilmSource> SourceFrom(const nlohmann::json& said) {
  if (!said.is_object() || !said.contains("name") || !said.contains("path") || !said.contains("digest"))
    return std::nullopt;
  const nlohmann::json &name = said["name"], &path = said["path"], &bytes = said["digest"];
  if (!name.is_string() || !path.is_string() || !bytes.is_array()) return std::nullopt;
  FilmSource source{{name.get<std::string>(), path.get<std::string>()}, {}};
  if (bytes.size() != source.digest.size()) return std::nullopt;
  for (std::size_t i = 0; i < source.digest.size(); ++i) {
    if (!bytes[i].is_number_integer()) return std::nullopt;
    source.digest[i] = static_cast<std::uint8_t>(bytes[i].get<std::int64_t>());
  }
  return source;
}

}  // namespace

Result<video::FlightFiles> TakeFilmFrames(const std::vector<flight::InputFile>& files,
                                          const fs::path& out_dir, int threads, Progress& progress) {
  const fs::path folder = out_dir / kFramesFolder;
  const std::vector<flight::InputFile> films = video::FilmsAmong(files);
  if (films.empty()) return video::FlightFiles{files, {}, {}};
  SKYQUILT_TRY(CheckIsOurs(folder));
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) return storage::FileError("cannot make", folder, failed.value());
  // Before the first frame, so that a run that is killed leaves a folder that the next one knows. The films
  // of a map that is there stay known until all frames are taken.
  if (!fs::exists(folder / kSourcesFile, failed)) SKYQUILT_TRY(WriteSources(folder, {}));
  video::TakeFramesOptions options;
  options.threads = threads;
  SKYQUILT_TRY_ASSIGN(video::FlightFiles taken,
                      video::WithFramesOfFilms(files, films, folder, options, progress));
  SKYQUILT_TRY(WriteSources(folder, taken.sources));
  return taken;
}

std::vector<FilmSource> SourcesOfFrames(const fs::path& out_dir) {
  const nlohmann::json list = ParseJsonFile(out_dir / kFramesFolder / kSourcesFile);
  std::vector<FilmSource> sources;
  if (!list.is_array()) return sources;
  for (const nlohmann::json& said : list) {
    if (auto source = SourceFrom(said)) sources.push_back(*std::move(source));
  }
  return sources;
}

bool IsFrameOf(const fs::path& out_dir, const flight::InputFile& input) {
  std::error_code none;  // an input that is gone is no frame of the map's
  return input.path.parent_path().filename() == kFramesFolder &&
         fs::exists(out_dir / kFramesFolder / kSourcesFile, none) &&
         fs::exists(out_dir / kFramesFolder / input.path.filename(), none);
}

}  // namespace skyquilt::server
