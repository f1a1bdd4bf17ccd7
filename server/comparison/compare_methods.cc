#include "server/comparison/compare_methods.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "core/base/try.h"
#include "core/pipeline/report/locate.h"
#include "server/comparison/reckon_row.h"
#include "server/jobs/stitch_job.h"
#include "server/terminal/terminal_progress.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using pipeline::AlignMethod;
using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<const char*, AlignMethod>, 4> kMethods{{{"imu", AlignMethod::kImu},
                                                                       {"features", AlignMethod::kFeatures},
                                                                       {"direct", AlignMethod::kDirect},
                                                                       {"auto", AlignMethod::kAuto}}};
constexpr int kExitCancelled = 130;
constexpr const char* kFailureFile = "failure.txt";

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// In the child: its exit code.
int StitchAlone(const std::vector<flight::InputFile>& files, const pipeline::MosaicOptions& options,
                const fs::path& folder) {
  StitchJobOptions job;
  job.mosaic = options;
  try {
    TerminalProgress progress;
    const Result<pipeline::MosaicReport> report = StitchToDirectory(files, job, folder, progress);
    if (report) return 0;
    if (report.error().code == ErrorCode::kCancelled) return kExitCancelled;
    const Result<void> written = storage::WriteFileAtomically(folder / kFailureFile, report.error().message);
    return written ? 1 : 2;
  } catch (const std::exception& out_of_something) {
    fmt::print(stderr, "skyquilt: {}\n", out_of_something.what());
    return 70;
  }
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

void ReadOutcome(const std::string& truth_json, MethodOutcome& outcome) {
  const Json report = Json::parse(ReadText(outcome.folder / "report.json"));
  const Json& photos = report.at("photos");
  outcome.photos = photos.at("total");
  outcome.aligned = photos.at("aligned");
  outcome.placed = outcome.aligned + photos.at("pose_only").get<int>();
  outcome.gsd_m = report.at("gsd_m");
  outcome.bounds = geo::LatLonBounds::FromArray(report.at("bounds"));
  outcome.min_zoom = report.at("min_zoom");
  outcome.max_zoom = report.at("max_zoom");
  if (const Json& alignment = report.at("alignment"); !alignment.is_null()) {
    outcome.residual_px = alignment.at("residual_rms_px").get<double>();
    outcome.pieces = alignment.at("pieces");
  }
  if (const Json& seams = report.at("seams"); !seams.is_null() && seams.at("reliable").get<int>() > 0) {
    outcome.seam_median_m = seams.at("median_m").get<double>();
    outcome.seam_p90_m = seams.at("p90_m").get<double>();
  }
  if (truth_json.empty()) return;
  const Result<pipeline::LocatedMap> map =
      pipeline::ParseLocateJson(ReadText(outcome.folder / "locate.json"));
  if (!map) return;
  if (const Result<TruthError> error = MeasureTruthError(*map, truth_json)) {
    outcome.truth = *error;
  }
}

Result<MethodOutcome> RunMethod(const char* name, const std::vector<flight::InputFile>& files,
                                const pipeline::MosaicOptions& options, const std::string& truth_json,
                                const fs::path& out_dir) {
  MethodOutcome outcome;
  outcome.method = name;
  outcome.folder = out_dir / name;
  std::error_code failed;
  fs::remove_all(outcome.folder, failed);
  fs::create_directories(outcome.folder, failed);
  if (failed)
    return Error{ErrorCode::kIo,
                 "The folder " + outcome.folder.string() + " cannot be made: " + failed.message() + ".", ""};
  fmt::print(stderr, "== {}\n", name);
  std::fflush(nullptr);
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child < 0)
    return Error{ErrorCode::kIo,
                 std::string("A process for the method cannot be started: ") + std::strerror(errno) + ".",
                 ""};
  if (child == 0) {
    const int code = StitchAlone(files, options, outcome.folder);
    std::fflush(nullptr);
    _exit(code);
  }
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0) {
    if (errno != EINTR)
      return Error{ErrorCode::kIo,
                   std::string("The process of the method was lost: ") + std::strerror(errno) + ".", ""};
  }
  outcome.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  outcome.cpu_s = Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  outcome.peak_memory_bytes = std::int64_t{usage.ru_maxrss} * 1024;
  if (WIFEXITED(status) && WEXITSTATUS(status) == kExitCancelled) {
    return Error{ErrorCode::kCancelled, "The comparison was cancelled.", ""};
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    ReadOutcome(truth_json, outcome);
  } else {
    outcome.photos = static_cast<int>(files.size());
    outcome.failure = ReadText(outcome.folder / kFailureFile);
    if (outcome.failure.empty()) outcome.failure = "its process ended before it had a map";
  }
  return outcome;
}

std::string Metres(const std::optional<double>& value) { return value ? fmt::format("{:.3f}", *value) : "-"; }

}  // namespace

Result<std::vector<MethodOutcome>> CompareMethods(const std::vector<flight::InputFile>& files,
                                                  const pipeline::MosaicOptions& options,
                                                  const std::string& truth_json, const fs::path& out_dir) {
  std::vector<MethodOutcome> outcomes;
  for (const auto& [name, method] : kMethods) {
    pipeline::MosaicOptions of_method = options;
    of_method.method = method;
    SKYQUILT_TRY_ASSIGN(MethodOutcome outcome, RunMethod(name, files, of_method, truth_json, out_dir));
    outcomes.push_back(std::move(outcome));
  }
  if (auto reckoned = ReckonRow(files)) outcomes.push_back(*std::move(reckoned));
  return outcomes;
}

std::string ComparisonMarkdown(const std::vector<MethodOutcome>& outcomes) {
  bool has_truth = false;
  for (const MethodOutcome& outcome : outcomes) has_truth |= outcome.truth.has_value();
  std::string text = fmt::format(
      "| method | photos placed | by images | pieces |{} residual px | seam shift m, median / p90 | seconds "
      "| CPU "
      "s | peak MiB |\n|---|---|---|---|{}---|---|---|---|---|\n",
      has_truth ? " error CE90 m, absolute / relative | worst photo m |" : "", has_truth ? "---|---|" : "");
  for (const MethodOutcome& outcome : outcomes) {
    const std::string cost = fmt::format("{:.1f} | {:.1f} | {:.0f} |", outcome.wall_s, outcome.cpu_s,
                                         static_cast<double>(outcome.peak_memory_bytes) / (1 << 20));
    if (!outcome.failure.empty()) {
      text += fmt::format("| {} | 0 of {}: {} | - | - |{} - | - | {}\n", outcome.method, outcome.photos,
                          outcome.failure, has_truth ? " - | - |" : "", cost);
      continue;
    }
    if (!outcome.note.empty()) {
      text += fmt::format("| {} | {} | - | - |{} - | - | {:.1f} | {:.1f} | - |\n", outcome.method,
                          outcome.note, has_truth ? " - | - |" : "", outcome.wall_s, outcome.cpu_s);
      continue;
    }
    std::string truth;
    if (has_truth) {
      truth = outcome.truth ? fmt::format(" {:.3f} / {:.3f} | {:.2f} |", outcome.truth->absolute_ce90_m,
                                          outcome.truth->relative_ce90_m, outcome.truth->worst_photo_m)
                            : " - | - |";
    }
    text += fmt::format("| {} | {} of {} | {} | {} |{} {} | {} / {} | {}\n", outcome.method, outcome.placed,
                        outcome.photos, outcome.aligned,
                        outcome.pieces > 0 ? std::to_string(outcome.pieces) : "-", truth,
                        outcome.residual_px ? fmt::format("{:.2f}", *outcome.residual_px) : "-",
                        Metres(outcome.seam_median_m), Metres(outcome.seam_p90_m), cost);
  }
  return text;
}

std::string ComparisonJson(const std::vector<MethodOutcome>& outcomes) {
  const auto number = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
  Json methods = Json::array();
  for (const MethodOutcome& outcome : outcomes) {
    Json method = {{"method", outcome.method},
                   {"failure", outcome.failure.empty() ? Json(nullptr) : Json(outcome.failure)},
                   {"note", outcome.note.empty() ? Json(nullptr) : Json(outcome.note)},
                   {"photos", outcome.photos},
                   {"placed", outcome.placed},
                   {"aligned", outcome.aligned},
                   {"pieces", outcome.pieces > 0 ? Json(outcome.pieces) : Json(nullptr)},
                   {"gsd_m", outcome.gsd_m},
                   {"residual_rms_px", number(outcome.residual_px)},
                   {"seam_median_m", number(outcome.seam_median_m)},
                   {"seam_p90_m", number(outcome.seam_p90_m)},
                   {"wall_s", outcome.wall_s},
                   {"cpu_s", outcome.cpu_s},
                   {"peak_memory_bytes", outcome.peak_memory_bytes},
                   {"truth", nullptr}};
    if (outcome.truth) {
      method["truth"] = {{"photos", outcome.truth->photos},
                         {"photos_true", outcome.truth->photos_true},
                         {"absolute_ce90_m", outcome.truth->absolute_ce90_m},
                         {"relative_ce90_m", outcome.truth->relative_ce90_m},
                         {"worst_photo_m", outcome.truth->worst_photo_m}};
    }
    methods.push_back(std::move(method));
  }
  return Json({{"methods", methods}}).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace skyquilt::server
