// ReadFlight: files in, a Flight out. Of photos it reads headers only (EXIF, XMP, image size), never pixels;
// logs, lists of positions and elevation models are recognised by content; the former are read whole, in
// bounded memory. Photos that cannot be read, and those that lie aside (aside/README.md: copies, panoramas,
// raw pictures, other cameras), are listed in left_out, logs that cannot be read in the warnings; one bad
// file never fails the flight. Files are read on `threads` threads; the result does not depend on how many.
// Fails only when nothing at all was given.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/flight.h"

namespace skyquilt::flight {

// Which files of a folder that is walked (`root`) are none of a flight, whatever they hold.
using PassesOver = std::function<bool(const std::filesystem::path& file, const std::filesystem::path& root)>;
// Is told of each folder that may not be looked into, and is passed over.
using TellsDenied = std::function<void(const std::filesystem::path& folder)>;

// Whether a folder may not be looked into.
bool IsDenied(const std::filesystem::path& folder);

// Folders are walked (sorted, hidden files skipped); files are taken as they are. Their paths are absolute.
Result<std::vector<InputFile>> ListInputFiles(const std::vector<std::filesystem::path>& paths,
                                              const PassesOver& passes_over = {},
                                              const TellsDenied& tells_denied = {});

// `threads`: 0 for all cores.
Result<Flight> ReadFlight(const std::vector<InputFile>& files, int threads, Progress& progress);

// One photo. Errors: kUnsupportedFormat, kCorrupt, kUnprocessable (a panorama), kIo.
Result<Photo> ReadPhoto(const InputFile& file);

}  // namespace skyquilt::flight
