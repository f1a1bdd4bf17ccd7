// WithFramesOfFilms: a flight's files with each film replaced by frames taken from it (take_frames.h), before
// anything is read. Subtitles of the film's name beside it (flight.MP4, flight.SRT or .ASS) go into the table
// of its frames and are not read again; those of no film's name are named where a film lacks its own. Frames
// have the time that the films' names say where each film has one, else that of the creation, which is named
// where a log is to place them. A film that cannot be read is named with its reason, and the others go on.
// Two films of one name keep apart by a number; small copies that cameras write beside films (.LRF) are left
// out. Errors: kCancelled, kIo.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/remarks/remark.h"
#include "core/video/take_frames.h"

namespace skyquilt::video {

struct FlightFiles {
  std::vector<flight::InputFile> files;
  std::vector<flight::InputFile> sources;  // the films that became frames, and the subtitles beside them
  std::vector<flight::Remark> warnings;
};

// Those that are films, by their first bytes.
std::vector<flight::InputFile> FilmsAmong(const std::vector<flight::InputFile>& files);

// `films`: those among `files`. Frames are written to `folder`, which is there.
Result<FlightFiles> WithFramesOfFilms(const std::vector<flight::InputFile>& files,
                                      const std::vector<flight::InputFile>& films,
                                      const std::filesystem::path& folder, const TakeFramesOptions& options,
                                      Progress& progress);

}  // namespace skyquilt::video
