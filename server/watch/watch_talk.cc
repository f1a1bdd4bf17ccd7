#include "server/watch/watch_talk.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>

#include "core/base/text/printable.h"
#include "server/terminal/tell.h"

namespace skyquilt::server {
namespace {

volatile sig_atomic_t watch_ends = 0;

void OnWatchSignal(int) { watch_ends = 1; }

void TakeWatchSignals(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;  // without SA_RESTART: who waits is woken
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

WatchTalk::WatchTalk() : is_terminal_(isatty(STDERR_FILENO) != 0) {
  watch_ends = 0;
  TakeWatchSignals(OnWatchSignal);
}

WatchTalk::~WatchTalk() {
  EndProgress();
  TakeWatchSignals(SIG_DFL);
}

void WatchTalk::Say(const std::string& line) {
  EndProgress();
  std::puts(Printable(line).c_str());  // a log that cannot be written ends no watch
  std::fflush(stdout);
}

void WatchTalk::SayOnce(const std::string& about, const std::string& line) {
  std::string& last = said_[about];
  if (last == line) return;
  last = line;
  Say(line);
}

void WatchTalk::Forget(const std::string& about) { said_.erase(about); }

bool WatchTalk::IsCancelled() const { return watch_ends != 0; }

void WatchTalk::BeginStage(std::string_view) {
  EndProgress();
  const std::lock_guard lock(mutex_);
  last_quarter_ = 0;
  drawn_at_ = std::chrono::steady_clock::now();
}

void WatchTalk::Report(double fraction, std::string_view message) {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (is_terminal_) {
    if (now - drawn_at_ < std::chrono::milliseconds(100) && fraction < 1.0) return;
    drawn_at_ = now;
    has_open_line_ = true;
    Tell(fmt::format("\r\x1b[K  {:3.0f} %  {}", 100.0 * fraction, Printable(std::string(message))));
    return;
  }
  const int quarter = static_cast<int>(fraction * 4.0);
  if (quarter <= last_quarter_ || now - drawn_at_ < std::chrono::seconds(2)) return;
  last_quarter_ = quarter;
  drawn_at_ = now;
  Tell(fmt::format("  {:.0f} % ({})\n", 100.0 * fraction, Printable(std::string(message))));
}

void WatchTalk::EndProgress() {
  const std::lock_guard lock(mutex_);
  if (has_open_line_) Tell("\r\x1b[K");
  has_open_line_ = false;
}

}  // namespace skyquilt::server
