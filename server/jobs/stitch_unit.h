// StitchUnit: one unit of a flight, from files and what other units left to what the next ones need. What the
// sandboxed process of a worker runs. Blocking; one call at a time per process. Errors: those of the stages;
// kCorrupt (what another unit left is damaged), kOutOfSpace, kIo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/pipeline/mosaic_options.h"
#include "server/jobs/unit_files.h"

namespace skyquilt::server {

struct UnitDone {
  std::int64_t blocks = 0;  // of the whole map; of placing
  std::vector<std::pair<std::string, double>> stages_s;
};

// `files`: to look at those of the unit, to place all of the flight, to render at least those of its photos.
// `units`: what others left; `out_dir`: is there, for what this one leaves.
Result<UnitDone> StitchUnit(const std::vector<flight::InputFile>& files, const UnitToDo& todo,
                            const UnitFiles& units, const std::filesystem::path& out_dir,
                            const pipeline::MosaicOptions& options, Progress& progress);

}  // namespace skyquilt::server
