#include "core/base/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>

namespace skyquilt {

int ThreadCount(int threads) {
  if (threads > 0) return threads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void ParallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  const std::size_t workers = std::min<std::size_t>(static_cast<std::size_t>(ThreadCount(threads)), count);
  if (workers <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    while (!failed) {
      const std::size_t i = next.fetch_add(1);
      if (i >= count) return;
      try {
        body(i);
      } catch (...) {
        std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        failed = true;
      }
    }
  };
  std::vector<std::thread> pool;
  pool.reserve(workers - 1);
  for (std::size_t i = 1; i < workers; ++i) pool.emplace_back(work);
  work();
  for (std::thread& thread : pool) thread.join();
  if (failure) std::rethrow_exception(failure);
}

Result<void> ParallelTry(std::size_t count, int threads,
                         const std::function<Result<void>(std::size_t)>& body) {
  std::mutex mutex;
  std::optional<Error> failure;
  ParallelFor(count, threads, [&](std::size_t i) {
    {
      const std::lock_guard lock(mutex);
      if (failure) return;
    }
    const Result<void> done = body(i);
    const std::lock_guard lock(mutex);
    if (!done && !failure) failure = done.error();
  });
  if (failure) return *failure;
  return {};
}

}  // namespace skyquilt
