// The messages between a worker and the sandboxed process that makes a map for it, as JSON texts. The worker
// sends a StitchTask. What the other sends is not trusted: ParseJobMessage accepts texts of bounded length in
// UTF-8 and figures that a map can have. Pure. Error: kUnprocessable.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "server/jobs/unit_files.h"
#include "storage/catalogue/catalogue.h"

namespace skyquilt::server {

struct StitchTask {
  std::vector<flight::InputFile> files;
  std::filesystem::path files_dir;     // where all of them are
  std::filesystem::path previous_dir;  // of the map that is shown; empty: none
  std::filesystem::path out_dir;       // is there, and empty or what a killed attempt left
  std::string options;                 // as api::ParseJobOptions reads them
  std::string title;
  // Of a flight that is cut into units (server/units): what they leave, and the one to do; without one the
  // whole map is made, from what `renders` of them rendered.
  std::filesystem::path units_dir = {};  // empty: it is not cut
  std::optional<UnitToDo> unit = {};
  int renders = 0;
  bool with_pmtiles = false;      // the map is to lie where its tiles are read by ranges
  std::int64_t memory_bytes = 0;  // address space beyond the program's own
  std::int64_t cpu_s = 0;
};

struct StageBegun {
  std::string stage;  // up to 32 of a-z, 0-9, _ and -
};
struct StageProgress {
  double fraction = 0.0;  // 0..1
  std::string message;
};
struct StitchOutcome {
  storage::Revision figures;  // without number and time
  std::vector<std::pair<std::string, double>> stages_s;
  std::int64_t blocks = 0;  // of the whole map, where a unit placed its flight
};
using JobMessage = std::variant<StageBegun, StageProgress, StitchOutcome, Error>;

std::string ToText(const StitchTask& task);
Result<StitchTask> ParseTask(std::string_view text);
std::string ToText(const JobMessage& message);
Result<JobMessage> ParseJobMessage(std::string_view text);

}  // namespace skyquilt::server
