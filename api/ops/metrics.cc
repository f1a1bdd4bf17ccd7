#include "api/ops/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace skyquilt::api {
namespace {

constexpr std::array kClassNames = {"tile", "api", "upload", "page"};

}  // namespace

void Metrics::CountRequest(RouteClass route_class, int status, std::chrono::nanoseconds took,
                           std::uint64_t bytes_out) {
  const auto c = static_cast<std::size_t>(route_class);
  const auto kind = static_cast<std::size_t>(std::clamp(status / 100, 1, kStatusKinds) - 1);
  requests_[c][kind].fetch_add(1, std::memory_order_relaxed);
  const double seconds = std::chrono::duration<double>(took).count();
  const auto bucket = static_cast<std::size_t>(std::lower_bound(kBucketsS.begin(), kBucketsS.end(), seconds) -
                                               kBucketsS.begin());
  latency_[c][bucket].fetch_add(1, std::memory_order_relaxed);
  latency_sum_ns_[c].fetch_add(static_cast<std::uint64_t>(took.count()), std::memory_order_relaxed);
  bytes_out_.fetch_add(bytes_out, std::memory_order_relaxed);
}

std::string Metrics::Text(const storage::JobCounts& jobs) const {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(
      out, "# HELP skyquilt_requests_total Requests answered.\n# TYPE skyquilt_requests_total counter\n");
  for (std::size_t c = 0; c < kClasses; ++c) {
    for (std::size_t k = 0; k < kStatusKinds; ++k) {
      fmt::format_to(out, "skyquilt_requests_total{{route=\"{}\",status=\"{}xx\"}} {}\n", kClassNames[c],
                     k + 1, requests_[c][k].load(std::memory_order_relaxed));
    }
  }
  fmt::format_to(out,
                 "# HELP skyquilt_request_seconds Time from the header to the answer.\n"
                 "# TYPE skyquilt_request_seconds histogram\n");
  for (std::size_t c = 0; c < kClasses; ++c) {
    std::uint64_t total = 0;
    for (std::size_t b = 0; b <= kBucketsS.size(); ++b) {
      total += latency_[c][b].load(std::memory_order_relaxed);
      const std::string bound = b < kBucketsS.size() ? fmt::format("{}", kBucketsS[b]) : "+Inf";
      fmt::format_to(out, "skyquilt_request_seconds_bucket{{route=\"{}\",le=\"{}\"}} {}\n", kClassNames[c],
                     bound, total);
    }
    fmt::format_to(out, "skyquilt_request_seconds_sum{{route=\"{}\"}} {}\n", kClassNames[c],
                   static_cast<double>(latency_sum_ns_[c].load(std::memory_order_relaxed)) * 1e-9);
    fmt::format_to(out, "skyquilt_request_seconds_count{{route=\"{}\"}} {}\n", kClassNames[c], total);
  }
  const auto single = [&](const char* name, const char* kind, const char* help, auto value) {
    fmt::format_to(out, "# HELP {0} {1}\n# TYPE {0} {2}\n{0} {3}\n", name, help, kind, value);
  };
  single("skyquilt_sent_bytes_total", "counter", "Body bytes sent.",
         bytes_out_.load(std::memory_order_relaxed));
  single("skyquilt_received_bytes_total", "counter", "Body bytes received.",
         bytes_in_.load(std::memory_order_relaxed));
  single("skyquilt_connections", "gauge", "Open connections.", connections_.load(std::memory_order_relaxed));
  fmt::format_to(out, "# HELP skyquilt_jobs Jobs by state.\n# TYPE skyquilt_jobs gauge\n");
  const auto state = [&](const char* name, int count) {
    fmt::format_to(out, "skyquilt_jobs{{state=\"{}\"}} {}\n", name, count);
  };
  state("accepted", jobs.accepted);
  state("running", jobs.running);
  state("successful", jobs.successful);
  state("failed", jobs.failed);
  state("dismissed", jobs.dismissed);
  fmt::format_to(
      out,
      "# HELP skyquilt_units Units of jobs that are cut, by state; those that are done are not counted.\n"
      "# TYPE skyquilt_units gauge\n"
      "skyquilt_units{{state=\"waiting\"}} {}\nskyquilt_units{{state=\"running\"}} {}\n",
      jobs.waiting_units, jobs.running_units);
  return text;
}

}  // namespace skyquilt::api
