// TakeFrames: from a film to photos: frames that overlap by a stated share, the sharpest of those in
// question, written as JPEGs, and beside them a table of where each was taken, from subtitles that the camera
// wrote into the film or beside it. Both are then read like any photos and any table. Where it is known when
// the film began, each frame has its time as a photo of a local clock does. Deterministic for any number of
// threads. Errors: those of VideoFile and of writing; kCancelled.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::video {

struct TakeFramesOptions {
  double overlap = 0.8;  // of each frame with the one taken before it
  int max_frames = 3000;
  int jpeg_quality = 95;
  int threads = 1;
  std::optional<flight::UtcTime> began_at;  // the film, by its camera's clock, of whatever zone
};

struct TakenFrames {
  std::vector<flight::InputFile> photos;   // named after the film and the number of the frame
  std::vector<double> times_s;             // by photo, in the film
  std::optional<flight::InputFile> table;  // absent: nothing says where the camera was
  std::vector<flight::Remark> warnings;
};

// Into `folder`, which is there. `subtitles`: of the same name as the film, beside it; may be empty.
Result<TakenFrames> TakeFrames(const flight::InputFile& film,
                               const std::optional<flight::InputFile>& subtitles,
                               const std::filesystem::path& folder, const TakeFramesOptions& options,
                               Progress& progress);

// The table of frames, as a CSV whose rows name their photo: what the log says at each time, between its
// samples by straight lines. Empty where the log says nothing of these times.
std::string FrameTable(const std::vector<std::string>& names, const std::vector<double>& times_s,
                       const flight::FlightLog& log);

}  // namespace skyquilt::video
