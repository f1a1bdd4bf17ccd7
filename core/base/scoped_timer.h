// ScopedTimer: adds the wall seconds of its scope to a number. One thread.
#pragma once

#include <chrono>
#include <ctime>

namespace skyquilt {

class ScopedTimer {
 public:
  explicit ScopedTimer(double& seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  ~ScopedTimer() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

// The same with the processor seconds of all the program's threads.
class ScopedCpuTimer {
 public:
  explicit ScopedCpuTimer(double& seconds) : seconds_(seconds), start_s_(NowS()) {}
  ~ScopedCpuTimer() { seconds_ += NowS() - start_s_; }
  ScopedCpuTimer(const ScopedCpuTimer&) = delete;
  ScopedCpuTimer& operator=(const ScopedCpuTimer&) = delete;

 private:
  static double NowS() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

  double& seconds_;
  const double start_s_;
};

}  // namespace skyquilt
