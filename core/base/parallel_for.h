// ParallelFor: runs body(i) for i in [0, count) on up to `threads` threads (0 = all cores). Items are handed
// out in order; the first exception stops the hand-out and is rethrown. With one thread it runs in the
// caller. ParallelOrdered: like it, but `consume(i, result)` is called by one thread at a time in the order
// of i, and at most `window` results wait: memory stays bounded and the outcome does not depend on the number
// of threads. ParallelCollect: what is found of some of them, in order. ParallelTry: the first error is the
// answer, and nothing is begun after it.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace skyquilt {

// The number of worker threads meant by `threads` (0 = all cores).
int ThreadCount(int threads);

void ParallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

Result<void> ParallelTry(std::size_t count, int threads,
                         const std::function<Result<void>(std::size_t)>& body);

// `find(i)` is an optional; those with nothing are left out.
template <typename Find>
auto ParallelCollect(std::size_t count, int threads, const Find& find) {
  using Found = std::invoke_result_t<const Find&, std::size_t>;
  std::vector<Found> found(count);
  ParallelFor(count, threads, [&](std::size_t i) { found[i] = find(i); });
  std::vector<typename Found::value_type> collected;
  for (Found& one : found) {
    if (one) collected.push_back(*std::move(one));
  }
  return collected;
}

template <typename T>
void ParallelOrdered(std::size_t count, int threads, std::size_t window,
                     const std::function<T(std::size_t)>& produce,
                     const std::function<void(std::size_t, T&&)>& consume) {
  std::mutex mutex;
  std::condition_variable room;
  std::map<std::size_t, T> waiting;
  std::size_t next = 0;
  bool consuming = false;
  bool failed = false;
  ParallelFor(count, threads, [&](std::size_t i) {
    {
      std::unique_lock lock(mutex);
      room.wait(lock, [&] { return failed || i < next + window; });
      if (failed) return;
    }
    try {
      T made = produce(i);
      std::unique_lock lock(mutex);
      waiting.emplace(i, std::move(made));
      if (consuming) return;  // whoever consumes now will take this one too
      consuming = true;
      for (auto it = waiting.find(next); it != waiting.end() && !failed; it = waiting.find(next)) {
        T item = std::move(it->second);
        waiting.erase(it);
        const std::size_t index = next;
        lock.unlock();
        consume(index, std::move(item));
        lock.lock();
        ++next;
        room.notify_all();
      }
      consuming = false;
    } catch (...) {
      std::lock_guard lock(mutex);
      failed = true;
      room.notify_all();
      throw;
    }
  });
}

}  // namespace skyquilt
