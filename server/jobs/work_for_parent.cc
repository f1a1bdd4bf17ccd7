#include "server/jobs/work_for_parent.h"

#include <cstdlib>

namespace skyquilt::server {
namespace {

constexpr std::chrono::minutes kTaskPatience{1};
// More often nobody looks.
constexpr std::chrono::milliseconds kTellEvery{100};

}  // namespace

int WorkForParent(
    int parent,
    const std::function<std::optional<JobMessage>(const std::string& task, MessageWriter& to_parent)>& work) {
  std::optional<MessageWriter> to_parent = MeetParent(parent);
  if (!to_parent) return 1;
  const std::optional<std::string> task = ParentsMessages().Read(kTaskPatience);
  if (!task) return 1;
  const std::optional<JobMessage> last = work(*task, *to_parent);
  return !last || to_parent->Write(ToText(*last)) ? 0 : 1;
}

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
