// The side of a sandboxed process that makes a map or an export: it hears of its task, tells how far it is
// and how it ended, as JobMessages (server/jobs/child_messages.h). Who wishes it to end, ends the process.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/progress.h"
#include "server/jobs/child_messages.h"
#include "server/sandbox/sandboxed_child.h"

namespace skyquilt::server {

// All that such a process does: `work` gets its task and answers the last message, if there is one to be
// sent. The exit code: 0 where that was sent, also when it is an error.
int WorkForParent(
    int parent,
    const std::function<std::optional<JobMessage>(const std::string& task, MessageWriter& to_parent)>& work);

// Ten times a second at most. Any number of threads.
class PipeProgress final : public Progress {
 public:
  explicit PipeProgress(MessageWriter& writer) : writer_(writer) {}

  void BeginStage(std::string_view stage) override;
  void Report(double fraction, std::string_view message) override;
  bool IsCancelled() const override { return false; }

 private:
  MessageWriter& writer_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point sent_;
};

// What SQLite and GDAL put down for a moment. Before other threads are started.
void KeepTemporaryFilesIn(const std::filesystem::path& folder);

}  // namespace skyquilt::server
