#include "core/base/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

namespace skyquilt {
namespace {

TEST(ParallelFor, VisitsEveryItemOnce) {
  for (const int threads : {1, 2, 7}) {
    std::vector<std::atomic<int>> visits(1000);
    ParallelFor(visits.size(), threads, [&](std::size_t i) { ++visits[i]; });
    for (const auto& count : visits) ASSERT_EQ(count, 1);
  }
}

TEST(ParallelTry, AnswersTheFirstErrorAndBeginsNothingAfterIt) {
  int begun = 0;
  const Result<void> done = ParallelTry(1000, 1, [&](std::size_t i) -> Result<void> {
    ++begun;
    if (i == 3) return Error{ErrorCode::kIo, "three", ""};
    return {};
  });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message, "three");
  EXPECT_EQ(begun, 4);
  EXPECT_TRUE(ParallelTry(10, 3, [](std::size_t) { return Result<void>(); }));
}

TEST(ParallelFor, RethrowsTheFirstFailureAndStops) {
  EXPECT_THROW(ParallelFor(100, 3,
                           [](std::size_t i) {
                             if (i == 10) throw std::runtime_error("ten");
                           }),
               std::runtime_error);
}

TEST(ParallelOrdered, ConsumesInOrderWithABoundedWindow) {
  for (const int threads : {1, 2, 5}) {
    std::vector<std::size_t> order;
    std::atomic<int> in_flight{0};
    std::atomic<int> most{0};
    ParallelOrdered<int>(
        500, threads, 6,
        [&](std::size_t i) {
          most = std::max(most.load(), ++in_flight);
          return static_cast<int>(i * i % 97);
        },
        [&](std::size_t i, int&& value) {
          EXPECT_EQ(value, static_cast<int>(i * i % 97));
          order.push_back(i);
          --in_flight;
        });
    ASSERT_EQ(order.size(), 500u);
    for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
    EXPECT_LE(most, 7);
  }
}

TEST(ParallelOrdered, RethrowsAConsumersFailureWithoutHanging) {
  EXPECT_THROW(ParallelOrdered<int>(
                   200, 4, 4, [](std::size_t i) { return static_cast<int>(i); },
                   [](std::size_t i, int&&) {
                     if (i == 20) throw std::runtime_error("twenty");
                   }),
               std::runtime_error);
}

}  // namespace
}  // namespace skyquilt
