// PipeProgress: how a sandboxed process that makes a map or an export tells its parent how far it is, as
// JobMessages (server/jobs/child_messages.h). Who wishes it to end, ends the process.
#pragma once

#include <chrono>
#include <filesystem>
#include <mutex>

#include "core/base/progress.h"
#include "server/jobs/child_messages.h"
#include "server/sandbox/sandboxed_child.h"

namespace skyquilt::server {

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
