#include "server/terminal/terminal_progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>

#include "core/base/text/plain_text.h"
#include "server/terminal/tell.h"

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;

volatile std::sig_atomic_t interrupted = 0;

void OnInterrupt(int) {
  if (interrupted != 0) std::_Exit(130);  // the second Ctrl-C does not wait
  interrupted = 1;
}

std::string StageWords(std::string_view stage) {
  if (stage == "read") return "Reading photos";
  if (stage == "check") return "Checking photos";
  if (stage == "pose") return "Estimating poses";
  if (stage == "align") return "Aligning";
  if (stage == "ground") return "Modelling the ground";
  if (stage == "plan") return "Planning";
  if (stage == "expose") return "Matching exposure";
  if (stage == "seam") return "Placing the seams";
  if (stage == "render") return "Rendering";
  if (stage == "measure") return "Measuring the seams";
  if (stage == "surface") return "Measuring heights";
  if (stage == "export") return "Writing the other formats";
  if (stage == "move") return "Copying and comparing";
  if (stage == "compare") return "Comparing maps";
  return std::string(stage);
}

// What wraps into the next row stays when the line is drawn anew.
std::string CutToRow(const std::string& line) {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return line;  // it does not say
  return CutToBytes(line, size.ws_col - 1U);
}

std::string Seconds(double seconds) {
  const auto whole = static_cast<long>(std::lround(seconds));
  return whole < 60 ? fmt::format("{} s", whole) : fmt::format("{}:{:02} min", whole / 60, whole % 60);
}

}  // namespace

TerminalProgress::TerminalProgress() : is_terminal_(isatty(STDERR_FILENO) != 0), stage_start_(Clock::now()) {
  interrupted = 0;
  std::signal(SIGINT, OnInterrupt);
  std::signal(SIGPIPE, SIG_IGN);  // whoever reads what is told here may be gone
}

TerminalProgress::~TerminalProgress() {
  EndStage();
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGPIPE, SIG_DFL);
}

bool TerminalProgress::IsCancelled() const { return interrupted != 0; }

void TerminalProgress::BeginStage(std::string_view stage) {
  EndStage();
  std::lock_guard lock(mutex_);
  stage_ = stage;
  stage_start_ = last_drawn_ = Clock::now();
  last_tenth_ = -1;
  if (is_terminal_) Draw(0.0, "");
}

void TerminalProgress::EndStage() {
  std::lock_guard lock(mutex_);
  if (stage_.empty()) return;
  const double took_s = std::chrono::duration<double>(Clock::now() - stage_start_).count();
  Tell(fmt::format("{}{}: {:.1f} s\n", is_terminal_ ? "\r\x1b[K" : "", StageWords(stage_), took_s));
  stage_.clear();
}

void TerminalProgress::Report(double fraction, std::string_view message) {
  std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  if (is_terminal_) {
    if (now - last_drawn_ < std::chrono::milliseconds(100) && fraction < 1.0) return;
    last_drawn_ = now;
    Draw(fraction, message);
    return;
  }
  const int tenth = static_cast<int>(fraction * 10.0);
  if (tenth <= last_tenth_ || now - last_drawn_ < std::chrono::seconds(2)) return;
  last_tenth_ = tenth;
  last_drawn_ = now;
  Tell(fmt::format("{}: {:.0f} % ({})\n", StageWords(stage_), 100.0 * fraction, message));
}

void TerminalProgress::Draw(double fraction, std::string_view message) {
  constexpr int kWidth = 28;
  const int filled = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * kWidth);
  std::string left;
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - stage_start_).count();
  if (fraction > 0.03 && elapsed_s > 1.0) left = Seconds(elapsed_s * (1.0 - fraction) / fraction) + " left  ";
  const std::string line =
      fmt::format("{:<20} [{}{}] {:3.0f} %  {}{}", StageWords(stage_), std::string(filled, '#'),
                  std::string(kWidth - filled, '.'), 100.0 * fraction, left, message);
  Tell("\r\x1b[K" + CutToRow(line));
}

}  // namespace skyquilt::server
