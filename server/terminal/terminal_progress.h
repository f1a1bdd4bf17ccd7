// TerminalProgress: progress for a person at a terminal (one bar that is rewritten, with the time left) or
// for a log (one line per stage and one every ten percent). Writes to stderr. The first Ctrl-C cancels the
// job cleanly. Any number of threads.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "core/base/progress.h"

namespace skyquilt::server {

class TerminalProgress final : public Progress {
 public:
  TerminalProgress();
  ~TerminalProgress() override;

  void BeginStage(std::string_view stage) override;
  void Report(double fraction, std::string_view message) override;
  bool IsCancelled() const override;

 private:
  void EndStage();
  void Draw(double fraction, std::string_view message);

  const bool is_terminal_;
  std::mutex mutex_;
  std::string stage_;
  std::chrono::steady_clock::time_point stage_start_;
  std::chrono::steady_clock::time_point last_drawn_;
  int last_tenth_ = -1;
};

}  // namespace skyquilt::server
