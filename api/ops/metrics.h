// Metrics: what the server counts, as Prometheus text (exposition format 0.0.4). Counting is lock-free; any
// thread.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "storage/jobs/job_queue.h"
#include "storage/jobs/unit_queue.h"
#include "storage/jobs/workers_aside.h"

namespace skyquilt::api {

enum class RouteClass { kTile, kApi, kUpload, kPage };

class Metrics {
 public:
  void CountRequest(RouteClass route_class, int status, std::chrono::nanoseconds took,
                    std::uint64_t bytes_out);
  void CountBytesIn(std::uint64_t bytes) { bytes_in_.fetch_add(bytes, std::memory_order_relaxed); }
  void ConnectionOpened() { connections_.fetch_add(1, std::memory_order_relaxed); }
  void ConnectionClosed() { connections_.fetch_sub(1, std::memory_order_relaxed); }
  // `units`: of the jobs that are cut. `aside`: workers whose machines are in trouble. `held`: which
  // worker has which unit.
  std::string Text(const storage::JobCounts& jobs, const std::vector<storage::UnitsOfKind>& units,
                   const std::vector<storage::WorkerAside>& aside = {},
                   const std::vector<storage::HeldUnit>& held = {}) const;

 private:
  static constexpr int kClasses = 4;
  static constexpr int kStatusKinds = 5;  // 1xx..5xx
  static constexpr std::array<double, 7> kBucketsS = {0.0005, 0.001, 0.005, 0.02, 0.1, 0.5, 2.0};
  using Counter = std::atomic<std::uint64_t>;
  std::array<std::array<Counter, kStatusKinds>, kClasses> requests_{};
  std::array<std::array<Counter, kBucketsS.size() + 1>, kClasses> latency_{};
  std::array<Counter, kClasses> latency_sum_ns_{};
  Counter bytes_out_{0};
  Counter bytes_in_{0};
  std::atomic<std::int64_t> connections_{0};
};

}  // namespace skyquilt::api
