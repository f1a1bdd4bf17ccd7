// SortFiles: which of the files given are photos, which are logs, lists of control points or of known
// reflectances, elevation models or films, and which are none of these and may be ignored. By content: the
// first bytes decide, whatever the name; the ending only says whether an unknown file is worth a complaint.
// Any thread.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/flight/bytes/input_file.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

struct SortedFiles {
  std::vector<InputFile> photos;  // and what cannot be told apart from one: reading it says what is wrong
  std::vector<InputFile> logs;
  std::vector<InputFile> gcp_lists;
  std::vector<InputFile> reflectance_lists;
  std::vector<InputFile> elevation_models;
  std::vector<InputFile> films;
  std::vector<InputFile> sidecars;  // XMP of photos, by ending and content
  std::vector<Remark> refused;      // what is known but cannot be read, or looks like a log, with advice
  std::optional<Remark> unused;     // what else is not used
};

SortedFiles SortFiles(const std::vector<InputFile>& files);

// For each file the index of the first one with the same bytes, nothing where there is none. Files of one
// size are compared by a hash of their start, then byte for byte; unreadable files equal nothing.
std::vector<std::optional<std::size_t>> FindDuplicates(const std::vector<InputFile>& files);

}  // namespace skyquilt::flight
