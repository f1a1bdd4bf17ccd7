// Silence: when the database last kept this process waiting for seconds, or lost its connection, and answered
// again. A lease that ran out meanwhile says nothing of its holder, who could not renew it either. Steady
// clock. Any thread.
#pragma once

#include <atomic>
#include <chrono>

namespace skyquilt::storage {

class Silence {
 public:
  using Clock = std::chrono::steady_clock;

  // An answer came that was asked for then.
  void Answered(Clock::time_point asked, Clock::time_point now = Clock::now()) {
    constexpr std::chrono::seconds kLong{2};
    if (now - asked > kLong) Ended(now);
  }
  void Ended(Clock::time_point now = Clock::now()) { end_ = now.time_since_epoch().count(); }
  bool EndedWithin(Clock::duration time, Clock::time_point now = Clock::now()) const {
    const Clock::rep end = end_;
    return end != kNever && now - Clock::time_point(Clock::duration(end)) < time;
  }

 private:
  static constexpr Clock::rep kNever = Clock::duration::min().count();
  std::atomic<Clock::rep> end_{kNever};
};

}  // namespace skyquilt::storage
