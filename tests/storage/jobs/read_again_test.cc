#include "storage/db/outage/read_again.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <vector>

namespace skyquilt::storage {
namespace {

using std::chrono::milliseconds;

TEST(ReadAgainTest, WaitsOnceForWhatDoesNotAnswerAndSeesItComeBack) {
  ReadAgain again(milliseconds(500));
  EXPECT_TRUE(again.Ask("a", [] { return Result<void>(); }));
  std::promise<void> thaw;
  const auto frozen = thaw.get_future().share();
  const auto read = [frozen]() -> Result<void> {
    frozen.wait();
    return {};
  };
  EXPECT_EQ(again.Ask("a", read).error().code, ErrorCode::kUnavailable);
  EXPECT_FALSE(again.IsWell());
  for (int i = 0; i < 1'000; ++i) EXPECT_FALSE(again.Ask(i % 2 == 0 ? "a" : "b", read));
  std::atomic<int> begun = 0;
  for (int i = 0; i < 2; ++i) {
    again.Begin("c", [&]() -> Result<void> {
      ++begun;
      return {};
    });
  }
  thaw.set_value();
  for (int i = 0; i < 1'000 && (!again.IsWell() || begun == 0); ++i)
    std::this_thread::sleep_for(milliseconds(5));
  EXPECT_EQ(begun, 1);
  EXPECT_TRUE(again.Ask("a", read));
}

TEST(ReadAgainTest, ReadsOnceForAllWhoAskAndTellsThemHowItEnded) {
  ReadAgain again(std::chrono::seconds(60));
  std::atomic<int> reads = 0;
  std::promise<void> go;
  const auto begun = go.get_future().share();
  std::vector<std::thread> askers;
  std::atomic<int> told = 0;
  for (int i = 0; i < 8; ++i) {
    askers.emplace_back([&] {
      const Result<void> outcome = again.Ask("a", [&]() -> Result<void> {
        ++reads;
        begun.wait();
        return Error{ErrorCode::kNotFound, "none", ""};
      });
      told += !outcome && outcome.error().code == ErrorCode::kNotFound ? 1 : 0;
    });
  }
  while (reads == 0) std::this_thread::sleep_for(milliseconds(1));
  std::this_thread::sleep_for(milliseconds(50));
  go.set_value();
  for (std::thread& asker : askers) asker.join();
  EXPECT_EQ(told, 8);
  EXPECT_LT(reads, 8);
  EXPECT_TRUE(again.IsWell());  // an answer is an answer
}

}  // namespace
}  // namespace skyquilt::storage
