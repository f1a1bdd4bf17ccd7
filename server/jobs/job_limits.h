// Resource limits of a job: generous for any flight, in proportion to the uploaded bytes, and an end to a
// file that was made to keep a decoder busy for ever. Any thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/pipeline/mosaic_options.h"

namespace skyquilt::server {

struct JobLimits {
  std::chrono::seconds wall{0};
  std::int64_t cpu_s = 0;         // of all threads
  std::int64_t memory_bytes = 0;  // of its own, beyond which it is ended
};

// What an operator says instead.
struct GivenLimits {
  std::optional<std::chrono::seconds> timeout = std::nullopt;
  std::optional<std::int64_t> memory_bytes = std::nullopt;
  // Of the machine or container, of which a job may take three quarters; 0: not known.
  std::int64_t machine_memory_bytes = 0;
};

// By its ending, in any case.
bool IsNameOfFilm(std::string_view name);

// Of how many photos a flight may be by this file: one, or a film's frames, which nobody has counted yet (4 a
// MiB, and no more than are ever taken).
std::int64_t MostPhotosIn(std::string_view name, std::int64_t bytes);

// `files`: the sum of these. Ten minutes, a minute a file and a second a MiB; twice as much processor time.
// Real flights take one to three seconds of processor time a photo. With a timeout given that instead, on the
// wall, and for each core on the processor. Memory: the options' budget, 4 GiB for what does not follow it
// (the program, features and matches, the solver), and 2 MiB per file.
JobLimits LimitsOfJob(std::int64_t files, std::int64_t bytes, const pipeline::MosaicOptions& options,
                      const GivenLimits& given);

// The memory that this machine has, or that its container may take. Reads /proc and /sys.
std::int64_t MemoryOfThisMachine();

}  // namespace skyquilt::server
