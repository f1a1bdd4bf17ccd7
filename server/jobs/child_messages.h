// What a process of ours and the sandboxed ones it starts say to each other, as JSON texts: one codec for the
// makers of maps (StitchTask), exports (ExportTask) and previews (PreviewPlace, then PreviewRequests). What a
// sandboxed process sends is not trusted: of that, texts of bounded length in UTF-8 are accepted and figures
// that a map or preview can have. Pure. Error: kUnprocessable.
#pragma once

#include <cstdint>
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
#include "storage/catalogue/previews.h"

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

struct ExportTask {
  std::filesystem::path map_dir;   // mosaic.mbtiles, report.json, perhaps mosaic.tif or bands.tif
  std::filesystem::path work_dir;  // all that it may write below
  std::string out_name;            // of the file that it leaves there
  std::string request;             // as storage::ParseExportRequest reads it
  int threads = 1;
  std::int64_t memory_bytes = 0;  // that it may write, beyond the program's own
  std::int64_t cpu_s = 0;
  std::int64_t file_bytes = 0;  // of any one file
};

// Of who makes a map or an export.
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

// Of one flight, for the life of the process that draws its preview.
struct PreviewPlace {
  std::filesystem::path files_dir;  // of the flight
  std::filesystem::path folder;     // of its preview; is there
  std::int64_t memory_bytes = 0;    // address space beyond the program's own
};

struct PreviewRequest {
  std::vector<storage::StoredFile> fresh;   // to be drawn
  std::vector<storage::StoredFile> tried;   // before them: they say which way the flight goes
  std::optional<storage::Preview> preview;  // as far as it is
};

// The process begins to work on a photo: whatever happens to it until it says more is that photo's doing.
struct PhotoBegun {
  std::string stored_name;
};
struct PreviewDrawn {
  std::optional<storage::Preview> preview;  // what it is now; nothing: it did not change
  std::vector<std::string> forgone;         // stored names of those that have no part in it
};
using PreviewMessage = std::variant<PhotoBegun, PreviewDrawn, Error>;

std::string ToText(const StitchTask& task);
Result<StitchTask> ParseTask(std::string_view text);
std::string ToText(const ExportTask& task);
Result<ExportTask> ParseExportTask(std::string_view text);
std::string ToText(const JobMessage& message);
Result<JobMessage> ParseJobMessage(std::string_view text);
std::string ToText(const PreviewPlace& place);
Result<PreviewPlace> ParsePlace(std::string_view text);
std::string ToText(const PreviewRequest& request);
Result<PreviewRequest> ParseRequest(std::string_view text);
std::string ToText(const PreviewMessage& message);
Result<PreviewMessage> ParsePreviewMessage(std::string_view text);

}  // namespace skyquilt::server
