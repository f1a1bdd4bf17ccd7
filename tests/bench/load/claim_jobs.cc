// claim_jobs CATALOGUE COUNT: claims so many jobs one after the other, each in a transaction of its own as a
// worker does, then gives them back. Prints how many and the median, 99th percentile and longest time in
// milliseconds.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <string_view>
#include <vector>

#include "storage/jobs/job_queue.h"

int main(int count, char** arguments) {
  using namespace skyquilt::storage;
  int wanted = 0;
  if (count == 3) {
    const std::string_view text(arguments[2]);
    std::from_chars(text.data(), text.data() + text.size(), wanted);
  }
  if (wanted < 1) {
    fmt::print(stderr, "usage: claim_jobs CATALOGUE COUNT\n");
    return 1;
  }
  auto db = CatalogueDb::Open(arguments[1]);
  if (!db) {
    fmt::print(stderr, "{}\n", db.error().message);
    return 1;
  }
  JobQueue queue(**db);
  std::vector<Lease> leases;
  std::vector<double> took_ms;
  for (int i = 0; i < wanted; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    const auto lease = queue.Claim("bench", Now());
    took_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    if (!lease) {
      fmt::print(stderr, "{}\n", lease.error().message);
      return 1;
    }
    if (!*lease) break;
    leases.push_back(**lease);
  }
  for (const Lease& lease : leases) {
    const auto back = queue.GiveBack(lease, Now());
    if (!back) fmt::print(stderr, "{}\n", back.error().message);
  }
  std::sort(took_ms.begin(), took_ms.end());
  fmt::print("{} {:.3f} {:.3f} {:.3f}\n", leases.size(), took_ms[took_ms.size() / 2],
             took_ms[took_ms.size() * 99 / 100], took_ms.back());
  return 0;
}
