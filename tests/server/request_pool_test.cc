#include "server/http/request_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>
#include <thread>
#include <vector>

namespace skyquilt::server {
namespace {

using std::chrono::milliseconds;
using Answer = RequestPool::Answer;

// Holds its thread until it is opened.
class Gate {
 public:
  RequestPool::Work Work() {
    return [this](bool) {
      ++arrived_;
      open_.get_future().wait();
    };
  }
  void WaitUntilHeld() const {
    while (arrived_ == 0) std::this_thread::sleep_for(milliseconds(1));
  }
  void Open() { open_.set_value(); }

 private:
  std::promise<void> open_;
  std::atomic<int> arrived_ = 0;
};

void WaitForIdle(const RequestPool& pool) {
  while (pool.load().running + pool.load().waiting > 0) std::this_thread::sleep_for(milliseconds(1));
}

TEST(RequestPool, RefusesWhatItHasNoRoomFor) {
  RequestPool pool({.name = "t", .threads = 1, .max_waiting = 2});
  Gate gate;
  ASSERT_EQ(pool.Submit("", gate.Work()), Answer::kTaken);
  gate.WaitUntilHeld();
  std::atomic<int> done = 0;
  const auto count = [&](bool) { ++done; };
  EXPECT_EQ(pool.Submit("", count), Answer::kTaken);
  EXPECT_EQ(pool.Submit("", count), Answer::kTaken);
  EXPECT_EQ(pool.Submit("", count), Answer::kFull);
  EXPECT_EQ(pool.load().waiting, 2u);
  EXPECT_EQ(pool.load().refused, 1u);
  gate.Open();
  WaitForIdle(pool);
  EXPECT_EQ(done, 2);
}

TEST(RequestPool, GivesAClientNoMoreThanItsShare) {
  RequestPool pool({.name = "t", .threads = 1, .max_waiting = 10, .max_of_client = 2});
  Gate gate;
  ASSERT_EQ(pool.Submit("a", gate.Work()), Answer::kTaken);
  gate.WaitUntilHeld();
  const auto nothing = [](bool) {};
  EXPECT_EQ(pool.Submit("a", nothing), Answer::kTaken);
  EXPECT_EQ(pool.Submit("a", nothing), Answer::kClientFull);  // one runs, one waits
  EXPECT_EQ(pool.Submit("b", nothing), Answer::kTaken);
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(pool.Submit("", nothing), Answer::kTaken);  // this machine has no share
  gate.Open();
  WaitForIdle(pool);
  EXPECT_EQ(pool.Submit("a", nothing), Answer::kTaken);
}

TEST(RequestPool, LetsClientsTakeTurns) {
  RequestPool pool({.name = "t", .threads = 1, .max_waiting = 10});
  Gate gate;
  ASSERT_EQ(pool.Submit("a", gate.Work()), Answer::kTaken);
  gate.WaitUntilHeld();
  std::string order;
  for (const char* client : {"a", "a", "a", "b", "b", "c"}) {
    pool.Submit(client, [&order, client](bool) { order += client; });
  }
  pool.Continue([&order] { order += "!"; });  // what is under way goes before what has not begun
  gate.Open();
  WaitForIdle(pool);
  EXPECT_EQ(order, "!abcaba");
}

TEST(RequestPool, BeginsWhatWaitsHoweverMuchIsUnderWay) {
  RequestPool pool({.name = "t", .threads = 1, .max_waiting = 10});
  Gate gate;
  ASSERT_EQ(pool.Submit("", gate.Work()), Answer::kTaken);
  gate.WaitUntilHeld();
  constexpr int kPieces = 1000;
  int pieces = 0, pieces_before = kPieces;
  const std::function<void()> next = [&] {
    if (++pieces < kPieces) pool.Continue(next);
  };
  pool.Continue(next);
  EXPECT_EQ(pool.Submit("a", [&](bool) { pieces_before = pieces; }), Answer::kTaken);
  gate.Open();
  WaitForIdle(pool);
  EXPECT_LT(pieces_before, 10);
  EXPECT_EQ(pieces, kPieces);
}

TEST(RequestPool, TellsThoseWhoWaitedTooLong) {
  RequestPool pool({.name = "t", .threads = 1, .max_waiting = 10, .max_wait = milliseconds(20)});
  Gate gate;
  ASSERT_EQ(pool.Submit("", gate.Work()), Answer::kTaken);
  gate.WaitUntilHeld();
  std::promise<bool> told;
  pool.Submit("", [&](bool is_late) { told.set_value(is_late); });
  std::this_thread::sleep_for(milliseconds(40));
  gate.Open();
  EXPECT_TRUE(told.get_future().get());
}

TEST(RequestPool, StopsWithinItsTimeWhateverRuns) {
  Gate gate;
  RequestPool pool({.name = "t", .threads = 2, .max_waiting = 10});
  ASSERT_EQ(pool.Submit("", gate.Work()), Answer::kTaken);
  gate.WaitUntilHeld();
  EXPECT_FALSE(pool.Stop(RequestPool::Clock::now() + milliseconds(30)));
  bool is_run = false;
  EXPECT_EQ(pool.Submit("", [&](bool) { is_run = true; }), Answer::kFull);
  gate.Open();
  EXPECT_TRUE(pool.Stop(RequestPool::Clock::now() + std::chrono::minutes(1)));
  EXPECT_FALSE(is_run);
}

TEST(RequestPool, DropsWhatWaitsWhenItStops) {
  auto held = std::make_shared<int>(0);
  Gate gate;
  RequestPool pool({.name = "t", .threads = 1, .max_waiting = 10});
  pool.Submit("", gate.Work());
  gate.WaitUntilHeld();
  pool.Submit("a", [held](bool) { ++*held; });
  pool.Continue([held] { ++*held; });
  EXPECT_EQ(held.use_count(), 3);
  EXPECT_FALSE(pool.Stop(RequestPool::Clock::now()));
  EXPECT_EQ(held.use_count(), 1);
  gate.Open();
  EXPECT_TRUE(pool.Stop(RequestPool::Clock::now() + std::chrono::minutes(1)));
  EXPECT_EQ(*held, 0);
}

TEST(RequestPool, DoesAllThatManyThreadsGiveIt) {
  RequestPool pool({.name = "t", .threads = 4, .max_waiting = 100'000, .max_of_client = 50'000});
  std::atomic<int> done = 0;
  std::vector<std::thread> givers;
  for (int giver = 0; giver < 4; ++giver) {
    givers.emplace_back([&, name = std::to_string(giver)] {
      for (int i = 0; i < 2000; ++i) {
        if (i % 3 == 0)
          pool.Continue([&] { ++done; });
        else
          EXPECT_EQ(pool.Submit(name, [&](bool) { ++done; }), Answer::kTaken);
      }
    });
  }
  for (std::thread& giver : givers) giver.join();
  WaitForIdle(pool);
  EXPECT_EQ(done, 8000);
}

}  // namespace
}  // namespace skyquilt::server
