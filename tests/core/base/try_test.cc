#include "core/base/try.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>

namespace skyquilt {
namespace {

Error Bad() { return {ErrorCode::kConflict, "It is bad.", "detail"}; }

Result<int> Positive(int number) {
  if (number <= 0) return Bad();
  return number;
}

Result<void> CheckPositive(int number) {
  if (number <= 0) return Bad();
  return {};
}

TEST(Try, GoesOnWithoutAnErrorAndReturnsOne) {
  int steps = 0;
  const auto run = [&](int number) -> Result<std::string> {
    SKYQUILT_TRY(CheckPositive(number));
    ++steps;
    SKYQUILT_TRY(Positive(number - 1));
    ++steps;
    return std::string("done");
  };
  EXPECT_EQ(*run(2), "done");
  EXPECT_EQ(steps, 2);
  const auto first = run(1);
  ASSERT_FALSE(first);
  EXPECT_EQ(steps, 3);
  EXPECT_EQ(first.error().code, ErrorCode::kConflict);
  EXPECT_EQ(first.error().message, "It is bad.");
  EXPECT_EQ(first.error().detail, "detail");
  EXPECT_FALSE(run(0));
  EXPECT_EQ(steps, 3);
}

TEST(Try, EvaluatesItsExpressionOnce) {
  int calls = 0;
  const auto run = [&]() -> Result<void> {
    SKYQUILT_TRY(CheckPositive(++calls));
    SKYQUILT_TRY_ASSIGN(const int number, Positive(++calls));
    EXPECT_EQ(number, 2);
    return {};
  };
  EXPECT_TRUE(run());
  EXPECT_EQ(calls, 2);
}

TEST(Try, StaysWithinTheBranchItIsIn) {
  const auto run = [](bool tries) -> Result<int> {
    if (tries)
      SKYQUILT_TRY(CheckPositive(0));
    else
      return 7;
    return 8;
  };
  EXPECT_EQ(*run(false), 7);
  EXPECT_FALSE(run(true));
}

TEST(TryAssign, DeclaresAndAssigns) {
  const auto run = [](int a, int b) -> Result<int> {
    SKYQUILT_TRY_ASSIGN(const int first, Positive(a));
    int second = 0;
    SKYQUILT_TRY_ASSIGN(second, Positive(b));
    return 10 * first + second;
  };
  EXPECT_EQ(*run(3, 4), 34);
  EXPECT_FALSE(run(0, 4));
  EXPECT_FALSE(run(3, 0));
}

TEST(TryAssign, MovesValuesThatCannotBeCopied) {
  const auto run = []() -> Result<std::unique_ptr<int>> {
    SKYQUILT_TRY_ASSIGN(std::unique_ptr<int> number, Result<std::unique_ptr<int>>(std::make_unique<int>(5)));
    ++*number;
    return number;
  };
  EXPECT_EQ(**run(), 6);
}

TEST(TryAssign, TakesExpressionsWithCommas) {
  const auto run = []() -> Result<int> {
    SKYQUILT_TRY_ASSIGN(const auto sizes, Result<std::map<int, int>>(std::map<int, int>{{1, 2}, {3, 4}}));
    SKYQUILT_TRY(Result<std::pair<int, int>>(std::pair<int, int>{1, 2}));
    return sizes.at(3);
  };
  EXPECT_EQ(*run(), 4);
}

TEST(TryAssign, WorksWithinALambdaOfAnotherOnesExpression) {
  const auto run = [](int number) -> Result<int> {
    SKYQUILT_TRY_ASSIGN(const int outer, [&]() -> Result<int> {
      SKYQUILT_TRY_ASSIGN(const int inner, Positive(number));
      SKYQUILT_TRY(CheckPositive(inner - 1));
      return inner + 1;
    }());
    return outer;
  };
  EXPECT_EQ(*run(2), 3);
  EXPECT_FALSE(run(1));
  EXPECT_FALSE(run(0));
}

}  // namespace
}  // namespace skyquilt
