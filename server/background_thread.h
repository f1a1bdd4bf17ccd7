// BackgroundThread: a thread that works in rounds, with rests between, until this object goes; whoever
// destroys it wakes it from a rest and waits for the round under way. The last member of its owner: the work
// may use all that stands before it. Any thread may ask.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace skyquilt::server {

class BackgroundThread {
 public:
  // `run` returns when IsEnded, or Rest, says so.
  explicit BackgroundThread(std::function<void()> run) : thread_(std::move(run)) {}
  ~BackgroundThread() {
    {
      const std::lock_guard lock(mutex_);
      is_ended_ = true;
    }
    end_.notify_all();
    thread_.join();
  }
  BackgroundThread(const BackgroundThread&) = delete;
  BackgroundThread& operator=(const BackgroundThread&) = delete;

  bool IsEnded() {
    const std::lock_guard lock(mutex_);
    return is_ended_;
  }
  // False: the end has come, perhaps before that time was over.
  bool Rest(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    return !end_.wait_for(lock, time, [this] { return is_ended_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable end_;
  bool is_ended_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace skyquilt::server
