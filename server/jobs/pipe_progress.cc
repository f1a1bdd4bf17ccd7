#include "server/jobs/pipe_progress.h"

#include <cstdlib>

namespace skyquilt::server {
namespace {

// More often nobody looks.
constexpr std::chrono::milliseconds kTellEvery{100};

}  // namespace

void PipeProgress::BeginStage(std::string_view stage) {
  const std::lock_guard lock(mutex_);
  sent_ = {};
  writer_.Write(ToText(JobMessage(StageBegun{std::string(stage)})));
}

void PipeProgress::Report(double fraction, std::string_view message) {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (now - sent_ < kTellEvery) return;
  sent_ = now;
  writer_.Write(ToText(JobMessage(StageProgress{fraction, std::string(message)})));
}

void KeepTemporaryFilesIn(const std::filesystem::path& folder) {
  for (const char* variable : {"TMPDIR", "SQLITE_TMPDIR", "CPL_TMPDIR"}) setenv(variable, folder.c_str(), 1);
}

}  // namespace skyquilt::server
