// claim_bench URL JOBS CLAIMANTS OWNERS PAUSE_MS: queues so many jobs of so many owners in a new schema of
// the PostgreSQL database, then lets so many claimants, each with connections of its own as a worker has,
// claim them one after the other and end them, with a pause of that length after each (0: at once, the worst
// there is). Prints how many were claimed, the claims per second, and the median, 99th percentile and longest
// time of a claim in milliseconds. Fails where a job was claimed twice or left.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "storage/db/ids.h"
#include "storage/jobs/job_queue.h"

namespace {

using namespace skyquilt::storage;
using Clock = std::chrono::steady_clock;

std::unique_ptr<CatalogueDb> Open(const CataloguePlace& place) {
  auto db = CatalogueDb::OpenPostgres(place, "bench", /*may_make=*/true, 1);
  if (db) return *std::move(db);
  fmt::print(stderr, "{} {}\n", db.error().message, db.error().detail);
  std::exit(1);
}

void Queue(CatalogueDb& catalogue, int jobs, int owners) {
  const auto db = catalogue.Lock();
  auto transaction = Transaction::Begin(*db);
  auto flight = *db->Prepare("INSERT INTO flight(id,name,created_us) VALUES(?,'x',0)");
  auto job = *db->Prepare("INSERT INTO job(id,flight_id,state,created_us,owner) VALUES(?,?,'accepted',0,?)");
  for (int i = 0; i < jobs; ++i) {
    const std::string id = fmt::format("{:08}", i);
    const std::string owner = owners < 2 ? "" : fmt::format("owner{}", i % owners);
    if (!flight.Bind(1, id).Run() || !job.Bind(1, id).Bind(2, id).Bind(3, owner).Run()) std::exit(1);
  }
  if (!transaction->Commit()) std::exit(1);
}

struct Measured {
  std::mutex mutex;
  std::multiset<std::string> jobs;
  std::vector<double> took_ms;
};

void ClaimAll(const CataloguePlace& place, const std::string& name, std::chrono::milliseconds pause,
              Measured& measured) {
  const auto db = Open(place);
  JobQueue queue(*db);
  while (true) {
    const auto begin = Clock::now();
    const auto lease = queue.Claim(name, Now());
    const double took_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    if (!lease) {
      fmt::print(stderr, "{}\n", lease.error().detail);
      std::exit(1);
    }
    if (!*lease) return;
    {
      const std::lock_guard lock(measured.mutex);
      measured.jobs.insert((*lease)->job_id);
      measured.took_ms.push_back(took_ms);
    }
    if (!queue.Dismiss(**lease, Now())) std::exit(1);
    std::this_thread::sleep_for(pause);
  }
}

}  // namespace

int main(int count, char** arguments) {
  std::vector<int> numbers;
  for (int i = 2; i < count; ++i) {
    const std::string_view text(arguments[i]);
    std::from_chars(text.data(), text.data() + text.size(), numbers.emplace_back(0));
  }
  if (numbers.size() != 4) {
    fmt::print(stderr, "usage: claim_bench URL JOBS CLAIMANTS OWNERS PAUSE_MS\n");
    return 1;
  }
  auto place = CataloguePlaceFrom(std::string(arguments[1]) + "&schema=bench" + NewId());
  if (!place) {
    fmt::print(stderr, "{}\n", place.error().message);
    return 1;
  }
  Queue(*Open(*place), numbers[0], numbers[2]);
  Measured measured;
  std::vector<std::thread> claimants;
  const auto begin = Clock::now();
  for (int i = 0; i < numbers[1]; ++i) {
    claimants.emplace_back([&, i] {
      ClaimAll(*place, fmt::format("bench-{}", i), std::chrono::milliseconds(numbers[3]), measured);
    });
  }
  for (std::thread& claimant : claimants) claimant.join();
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  std::vector<double>& took_ms = measured.took_ms;
  std::sort(took_ms.begin(), took_ms.end());
  const std::set<std::string> once(measured.jobs.begin(), measured.jobs.end());
  if (once.size() != measured.jobs.size() || static_cast<int>(once.size()) != numbers[0]) {
    fmt::print(stderr, "{} claims of {} jobs, {} of them different\n", measured.jobs.size(), numbers[0],
               once.size());
    return 1;
  }
  fmt::print("{} {:.0f} {:.2f} {:.2f} {:.2f}\n", took_ms.size(),
             static_cast<double>(took_ms.size()) / seconds, took_ms[took_ms.size() / 2],
             took_ms[took_ms.size() * 99 / 100], took_ms.back());
  return 0;
}
