// WatchTalk: what a watch of folders says (lines for a person or a log on standard output, the progress of an
// upload on standard error) and the signals that end it: SIGINT and SIGTERM, from its making to its end. What
// was said last is not said again. One object per process; Progress from any thread.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>

#include "core/base/progress.h"

namespace skyquilt::server {

class WatchTalk final : public Progress {
 public:
  WatchTalk();
  ~WatchTalk() override;

  // Told apart by `about`: the same line about the same is said once, until another is.
  void Say(const std::string& line);
  void SayOnce(const std::string& about, const std::string& line);
  void Forget(const std::string& about);

  void BeginStage(std::string_view stage) override;
  void Report(double fraction, std::string_view message) override;
  bool IsCancelled() const override;
  // Ends the line of progress on a terminal.
  void EndProgress();

 private:
  const bool is_terminal_;
  std::mutex mutex_;
  bool has_open_line_ = false;
  int last_quarter_ = 0;
  std::chrono::steady_clock::time_point drawn_at_;
  std::map<std::string, std::string> said_;  // the last line about each
};

}  // namespace skyquilt::server
