#include "storage/blobs/local_cache.h"

#include <gtest/gtest.h>
#include <utime.h>

#include <atomic>
#include <fstream>
#include <thread>
#include <vector>

#include "core/base/try.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;
constexpr std::int64_t kMib = std::int64_t{1} << 20;

LocalCache::Fetch Of(std::size_t bytes, std::atomic<int>* count = nullptr) {
  return [bytes, count](const fs::path& to) -> Result<void> {
    if (count != nullptr) ++*count;
    std::ofstream(to, std::ios::binary) << std::string(bytes, 'x');
    return {};
  };
}

// As if it was used so long ago.
void Age(const fs::path& path, int seconds) {
  const utimbuf times{time(nullptr) - seconds, time(nullptr) - seconds};
  utime(path.c_str(), &times);
}

std::unique_ptr<LocalCache> Open(const test::TemporaryFolder& folder, std::int64_t budget) {
  return *LocalCache::Open(folder / "cache", budget);
}

TEST(LocalCache, FetchesOnceForAllThatAskTogether) {
  const test::TemporaryFolder folder;
  const auto cache = Open(folder, 100 * kMib);
  std::atomic<int> fetched{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      const auto blob = cache->Get("flights/a/files/x", Of(1000, &fetched));
      EXPECT_EQ(fs::file_size(blob->path), 1000U);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(fetched, 1);
}

TEST(LocalCache, LeavesNothingOfAFetchThatFailed) {
  const test::TemporaryFolder folder;
  const auto cache = Open(folder, 100 * kMib);
  const auto blob = cache->Get("flights/a/files/x", [](const fs::path& to) -> Result<void> {
    std::ofstream(to) << "half";
    return Error{ErrorCode::kUnavailable, "away", ""};
  });
  EXPECT_EQ(blob.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(cache->Measure(), 0);
  EXPECT_TRUE(fs::is_empty(folder / "cache" / ".fetching"));
  EXPECT_TRUE(cache->Get("flights/a/files/x", Of(10)));
}

TEST(LocalCache, LetsGoOfWhatWasNotUsedForLongest) {
  const test::TemporaryFolder folder;
  const auto cache = Open(folder, 10 * kMib);
  for (int i = 0; i < 9; ++i) {
    const auto blob = cache->Get("flights/f" + std::to_string(i) + "/files/x", Of(kMib));
    Age(blob->path, 1000 - i);
  }
  ASSERT_TRUE(cache->Find("flights/f0/files/x"));  // used now
  for (int i = 9; i < 13; ++i)
    ASSERT_TRUE(cache->Get("flights/f" + std::to_string(i) + "/files/x", Of(kMib)));
  EXPECT_LE(cache->Measure(), 10 * kMib);
  EXPECT_TRUE(cache->Find("flights/f0/files/x"));
  EXPECT_FALSE(cache->Find("flights/f1/files/x"));
  EXPECT_FALSE(fs::exists(folder / "cache" / "flights" / "f1" / "files"));
  EXPECT_TRUE(cache->Find("flights/f12/files/x"));
}

TEST(LocalCache, KeepsWhatIsInUseThoughItBeTooMuch) {
  const test::TemporaryFolder folder;
  const auto cache = Open(folder, 4 * kMib);
  std::vector<LocalBlob> in_use;
  for (int i = 0; i < 8; ++i) {
    in_use.push_back(*cache->Get("flights/a/files/" + std::to_string(i), Of(kMib)));
    Age(in_use.back().path, 1000);
  }
  ASSERT_TRUE(cache->Get("flights/b/files/x", Of(kMib)));
  for (const LocalBlob& blob : in_use) EXPECT_TRUE(fs::exists(blob.path));
  in_use.clear();
  const auto again = Open(folder, 4 * kMib);  // as another process, or after a restart
  EXPECT_LE(again->Measure(), 4 * kMib);
}

TEST(LocalCache, KeepsWhatAnotherProcessUses) {
  const test::TemporaryFolder folder;
  const auto mine = Open(folder, 4 * kMib);
  const auto theirs = Open(folder, 4 * kMib);
  const auto used = theirs->Get("flights/a/files/x", Of(kMib));
  Age(used->path, 1000);
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(mine->Get("flights/b" + std::to_string(i) + "/files/x", Of(kMib)));
  EXPECT_TRUE(fs::exists(used->path));
}

TEST(LocalCache, ForgetsAFlight) {
  const test::TemporaryFolder folder;
  const auto cache = Open(folder, 100 * kMib);
  ASSERT_TRUE(cache->Get("flights/a/files/x", Of(10)));
  ASSERT_TRUE(cache->Get("flights/b/files/x", Of(10)));
  cache->ForgetBelow("flights/a/");
  EXPECT_FALSE(cache->Find("flights/a/files/x"));
  EXPECT_TRUE(cache->Find("flights/b/files/x"));
}

// Threads that fetch, use and push out each other's files: none ever finds its own gone.
TEST(LocalCache, HoldsUnderManyThreads) {
  const test::TemporaryFolder folder;
  const auto cache = Open(folder, 3 * kMib);
  std::atomic<int> missing{0};
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&, thread] {
      for (int i = 0; i < 200; ++i) {
        const std::string key = "flights/f" + std::to_string((i * (thread + 3)) % 17) + "/files/x";
        const auto blob = cache->Get(key, Of(kMib / 4));
        if (!blob || !fs::exists(blob->path) || fs::file_size(blob->path) != kMib / 4) ++missing;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(missing, 0);
}

}  // namespace
}  // namespace skyquilt::storage
