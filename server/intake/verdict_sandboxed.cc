#include "server/intake/verdict_sandboxed.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "api/json/job_options.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/pipeline/inspect_flight.h"
#include "core/pipeline/placing/control_points.h"
#include "server/inputs/open_elevation_model.h"
#include "server/sandbox/run_sandboxed.h"
#include "server/sandbox/sandbox.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::string_view kProjections = "libproj.so";  // what is loaded late and needed here
// Headers of photos take next to nothing, a log of half an hour some dozens of MiB. Long logs take more
// (core/flight/logs/log_builder.h has their caps), but they are large files: what small ones take is theirs
// to prove.
constexpr std::int64_t kDataBytes = std::int64_t{200} << 20;
constexpr std::int64_t kDataBytesPerLargeByte = 4;
constexpr std::int64_t kMaxDataBytes = std::int64_t{1} << 30;
constexpr std::uintmax_t kLargeFile = std::uintmax_t{32} << 20;
// A thousand photos take about a second of CPU, a log a second a 100 MB. On top of that come slow machines.
constexpr std::int64_t kVerdictCpuS = 20;
constexpr std::size_t kPhotosPerCpuS = 100;
constexpr std::uintmax_t kBytesPerCpuS = std::uintmax_t{64} << 20;
constexpr std::int64_t kMaxCpuS = 300;
constexpr std::int64_t kVerdictWallSecondsPerCpuSecond = 2;
constexpr const char* kVerdictRefusal =
    "The files could not be inspected: reading them took more memory or time than the server gives for it. A log or "
    "a photo among them may be damaged; remove it, or add the files a few at a time to find it.";

// Of the files that are long logs if they are logs: only these are read whole, but which files are logs their
// bytes tell, not their names.
std::uintmax_t LargeBytes(const std::vector<flight::InputFile>& files) {
  std::uintmax_t bytes = 0;
  for (const flight::InputFile& file : files) {
    std::error_code missing;  // then the inspection says so
    const std::uintmax_t size = fs::file_size(file.path, missing);
    if (!missing && size > kLargeFile) bytes += size;
  }
  return bytes;
}

std::int64_t CpuSecondsFor(const std::vector<flight::InputFile>& files) {
  const auto more =
      static_cast<std::int64_t>(files.size() / kPhotosPerCpuS + LargeBytes(files) / kBytesPerCpuS);
  return std::min(kVerdictCpuS + more, kMaxCpuS);
}

std::int64_t DataBytesFor(const std::vector<flight::InputFile>& files) {
  return std::min(kDataBytes + kDataBytesPerLargeByte * static_cast<std::int64_t>(LargeBytes(files)),
                  kMaxDataBytes);
}

Result<std::string> Inspect(const std::vector<flight::InputFile>& files, const std::string& options) {
  SKYQUILT_TRY_ASSIGN(const pipeline::MosaicOptions mosaic, api::ParseJobOptions(options));
  SilentProgress progress;
  SKYQUILT_TRY_ASSIGN(const auto elevations, OpenElevationModel(mosaic.dem_path, files));
  SKYQUILT_TRY_ASSIGN(auto verdict,
                      pipeline::InspectFlight(files, mosaic, progress, elevations.source.get()));
  verdict.warnings.insert(verdict.warnings.end(), elevations.warnings.begin(), elevations.warnings.end());
  return pipeline::VerdictJson(verdict);
}

}  // namespace

Result<std::string> VerdictSandboxed(const std::vector<flight::InputFile>& files,
                                     const std::string& options) {
  Json input = {{"options", options}, {"files", Json::array()}};
  for (const flight::InputFile& file : files)
    input["files"].push_back({{"name", file.name}, {"path", file.path.string()}});
  return RunSandboxed(
      {.command = "verdict",
       .task = JsonText(input),
       .deadline = std::chrono::seconds(kVerdictWallSecondsPerCpuSecond * CpuSecondsFor(files)),
       .refusal = kVerdictRefusal});
}

int VerdictInSandbox(int parent) {
  return AnswerParent(parent, [](const std::string& task) -> Result<std::string> {
    const Json input = ParseJson(task);  // by our own server; if not, the exception ends us
    std::vector<flight::InputFile> files;
    SandboxNeeds needs{.library = kProjections};
    for (const Json& file : input.at("files")) {
      files.push_back({file.at("name"), file.at("path").get<std::string>()});
      needs.files.reads.push_back(files.back().path);
    }
    needs.limits.more_data_bytes = DataBytesFor(files);
    needs.limits.more_cpu_s = CpuSecondsFor(files);
    SKYQUILT_TRY(EnterSandbox(std::move(needs)));
    return Inspect(files, input.at("options"));
  });
}

namespace {

constexpr std::int64_t kControlDataBytes = std::int64_t{200} << 20;
constexpr std::int64_t kControlCpuS = 10;
constexpr const char* kControlRefusal =
    "The list of control points could not be read: it took more memory or time than the server gives for it.";

}  // namespace

Result<std::string> ControlSandboxed(const fs::path& list) {
  return RunSandboxed({.command = "control",
                       .task = list.string(),
                       .deadline = std::chrono::seconds(3 * kControlCpuS),
                       .refusal = kControlRefusal});
}

int ControlInSandbox(int parent) {
  return AnswerParent(parent, [](const fs::path& list) -> Result<std::string> {
    SKYQUILT_TRY(EnterSandbox({.limits = {.more_data_bytes = kControlDataBytes, .more_cpu_s = kControlCpuS},
                               .files = {.reads = {list}},
                               .library = kProjections}));
    SKYQUILT_TRY_ASSIGN(const flight::GcpList points, flight::ReadGcpList({"gcp_list.txt", list}));
    return pipeline::ControlJson(points);
  });
}

}  // namespace skyquilt::server
