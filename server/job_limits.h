// What a job may take of the machine: generous for any flight, in proportion to what was uploaded, and an end
// to a file that was made to keep a decoder busy for ever. Pure; any thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/pipeline/mosaic_options.h"

namespace skyquilt::server {

struct JobLimits {
  std::chrono::seconds wall{0};
  std::int64_t cpu_s = 0;         // of all threads
  std::int64_t memory_bytes = 0;  // of its own, beyond which it is ended
};

// Ten minutes, a minute a file and a second a MiB; twice as much processor time. Real flights take one to
// three seconds of processor time a photo. With `timeout` that instead, on the wall, and for each core on the
// processor. Memory: the options' budget, 4 GiB for what does not follow it (the program, features and
// matches, the solver), and 2 MiB a file.
JobLimits LimitsOfJob(std::int64_t files, std::int64_t bytes, const pipeline::MosaicOptions& options,
                      std::optional<std::chrono::seconds> timeout);

}  // namespace skyquilt::server
