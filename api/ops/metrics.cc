#include "api/ops/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "core/base/text/xml_text.h"

namespace skyquilt::api {
namespace {

constexpr std::array kClassNames = {"tile", "api", "upload", "page"};

// Kinds that are named also while there are none, so that a series is zero and not absent.
constexpr std::array kUnitKinds = {"look", "render"};

std::map<std::string, storage::UnitsOfKind> ByKind(const std::vector<storage::UnitsOfKind>& units) {
  std::map<std::string, storage::UnitsOfKind> by_kind;
  for (const char* kind : kUnitKinds) by_kind[kind].kind = kind;
  for (const storage::UnitsOfKind& units_of_kind : units) by_kind[units_of_kind.kind] = units_of_kind;
  return by_kind;
}

// Names of workers are their operators' own.
std::string InLabel(const std::string& value) {
  return Escaped(value, {{'\\', "\\\\"}, {'"', "\\\""}, {'\n', " "}});
}

void WriteUnits(const std::vector<storage::UnitsOfKind>& units, std::string& text) {
  const auto out = std::back_inserter(text);
  const auto by_kind = ByKind(units);
  fmt::format_to(out,
                 "# HELP skyquilt_units Units of jobs that are cut and have not ended, by kind and state.\n"
                 "# TYPE skyquilt_units gauge\n");
  for (const auto& [kind, count] : by_kind) {
    const auto line = [&, &name = kind](const char* state, int value) {
      fmt::format_to(out, "skyquilt_units{{kind=\"{}\",state=\"{}\"}} {}\n", name, state, value);
    };
    line("waiting", count.waiting);
    line("running", count.running);
    line("done", count.done);
  }
  fmt::format_to(out,
                 "# HELP skyquilt_unit_failed_attempts Attempts at these units that came to nothing.\n"
                 "# TYPE skyquilt_unit_failed_attempts gauge\n");
  for (const auto& [kind, count] : by_kind)
    fmt::format_to(out, "skyquilt_unit_failed_attempts{{kind=\"{}\"}} {}\n", kind, count.failed_attempts);
  fmt::format_to(out,
                 "# HELP skyquilt_unit_longest_waiting_seconds How long the oldest waiting unit has waited.\n"
                 "# TYPE skyquilt_unit_longest_waiting_seconds gauge\n");
  for (const auto& [kind, count] : by_kind) {
    fmt::format_to(out, "skyquilt_unit_longest_waiting_seconds{{kind=\"{}\"}} {:.3f}\n", kind,
                   count.longest_waiting_s);
  }
}

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

std::string Metrics::Text(const storage::JobCounts& jobs, const std::vector<storage::UnitsOfKind>& units,
                          const std::vector<storage::WorkerAside>& aside,
                          const std::vector<storage::HeldUnit>& held) const {
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
  WriteUnits(units, text);
  fmt::format_to(
      out,
      "# HELP skyquilt_unit_held_seconds For how long a worker has had the unit that it works on.\n"
      "# TYPE skyquilt_unit_held_seconds gauge\n");
  for (const storage::HeldUnit& unit : held) {
    fmt::format_to(
        out,
        "skyquilt_unit_held_seconds{{job=\"{}\",kind=\"{}\",part=\"{}\",worker=\"{}\",attempt=\"{}\"}} {:.3f}\n",
        unit.job_id, unit.kind, unit.number + 1, InLabel(unit.worker), unit.attempt, unit.held_s);
  }
  fmt::format_to(
      out,
      "# HELP skyquilt_worker_aside_times How often in a row a worker gave back what it had for trouble "
      "of its machine.\n# TYPE skyquilt_worker_aside_times gauge\n");
  for (const storage::WorkerAside& worker : aside) {
    fmt::format_to(out, "skyquilt_worker_aside_times{{worker=\"{}\",code=\"{}\"}} {}\n",
                   InLabel(worker.worker), worker.code, worker.times);
  }
  return text;
}

}  // namespace skyquilt::api
