// The folder `frames` of a map that is made from films: the frames that became its photos, and frames.json,
// which says from which films (with their digests) and subtitles, and that the folder is ours. Blocking; one
// call at a time. Errors: kConflict (a folder of that name that is not ours), kIo, kCancelled.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/digest.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/video/films.h"

namespace skyquilt::server {

inline constexpr const char* kFramesFolder = "frames";

// The files with each film replaced by its frames, which are below `out_dir` then.
Result<video::FlightFiles> TakeFilmFrames(const std::vector<flight::InputFile>& files,
                                          const std::filesystem::path& out_dir, int threads,
                                          Progress& progress);

struct FilmSource {
  flight::InputFile file;  // a film, or the subtitles beside one
  Digest digest;
};

// What the frames below `out_dir` were made from; nothing where no map was made from films, or none says so.
std::vector<FilmSource> SourcesOfFrames(const std::filesystem::path& out_dir);

// Whether this input of the map in `out_dir` is one of its own frames, or their table.
bool IsFrameOf(const std::filesystem::path& out_dir, const flight::InputFile& input);

}  // namespace skyquilt::server
