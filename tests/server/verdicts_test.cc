#include "server/intake/verdicts.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <stdexcept>
#include <thread>

namespace skyquilt::server {
namespace {

const std::vector<flight::InputFile> kFiles = {{"a.jpg", "/flights/1/files/x"}};
const std::vector<flight::InputFile> kOthers = {{"a.jpg", "/flights/1/files/y"}};

// An inspection that lasts until it is let go.
struct Slow {
  std::atomic<int> begun{0};
  std::promise<void> go;
  std::shared_future<void> gone{go.get_future()};

  Verdicts::Inspect Inspect() {
    return [this](const std::vector<flight::InputFile>& files, const std::string&) -> Result<std::string> {
      ++begun;
      gone.wait();
      return files.front().path.string();
    };
  }
  void AwaitBegun(int count) const {
    while (begun < count) std::this_thread::yield();
  }
};

TEST(Verdicts, SameFilesAndOptionsAreInspectedOnce) {
  int inspected = 0;
  Verdicts verdicts([&](const auto&, const std::string& options) -> Result<std::string> {
    ++inspected;
    return options;
  });
  EXPECT_EQ(*verdicts.Of(kFiles, "{}"), "{}");
  EXPECT_EQ(*verdicts.Of(kFiles, "{}"), "{}");
  EXPECT_EQ(inspected, 1);
  EXPECT_EQ(*verdicts.Of(kFiles, "{\"quality\":1}"), "{\"quality\":1}");
  EXPECT_EQ(inspected, 2);
  ASSERT_TRUE(verdicts.Of(kOthers, "{}"));
  ASSERT_TRUE(verdicts.Of({kFiles.front(), kOthers.front()}, "{}"));
  ASSERT_TRUE(verdicts.Of({{"b.jpg", kFiles.front().path}}, "{}"));
  EXPECT_EQ(inspected, 5);
}

TEST(Verdicts, WhoAsksMeanwhileWaitsForTheSameInspection) {
  Slow slow;
  Verdicts verdicts(slow.Inspect(), {.callers = 3});
  std::vector<std::future<Result<std::string>>> asking;
  for (int i = 0; i < 3; ++i) {
    asking.push_back(std::async(std::launch::async, [&] { return verdicts.Of(kFiles, "{}"); }));
  }
  slow.AwaitBegun(1);
  slow.go.set_value();
  for (auto& each : asking) EXPECT_EQ(*each.get(), "/flights/1/files/x");
  EXPECT_EQ(slow.begun, 1);
}

TEST(Verdicts, TooManyAreToldToComeBack) {
  Slow slow;
  Verdicts verdicts(slow.Inspect(), {.at_once = 1, .callers = 2});
  auto first = std::async(std::launch::async, [&] { return verdicts.Of(kFiles, "{}"); });
  slow.AwaitBegun(1);
  const Result<std::string> other = verdicts.Of(kOthers, "{}");
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::kUnavailable);
  slow.go.set_value();
  EXPECT_TRUE(first.get());
  EXPECT_TRUE(verdicts.Of(kOthers, "{}"));  // nothing of the refusal was kept
}

TEST(Verdicts, RefusalsAreKeptForAWhileAndWantOfMeansIsNot) {
  int inspected = 0;
  ErrorCode code = ErrorCode::kUnprocessable;
  const Verdicts::Inspect refuse = [&](const auto&, const auto&) -> Result<std::string> {
    ++inspected;
    return Error{code, "no", ""};
  };
  Verdicts verdicts(refuse);
  EXPECT_FALSE(verdicts.Of(kFiles, "{}"));
  EXPECT_FALSE(verdicts.Of(kFiles, "{}"));
  EXPECT_EQ(inspected, 1);
  Verdicts forgetful(refuse, {.refusals_kept = std::chrono::seconds(-1)});
  EXPECT_FALSE(forgetful.Of(kFiles, "{}"));
  EXPECT_FALSE(forgetful.Of(kFiles, "{}"));
  EXPECT_EQ(inspected, 3);
  for (const ErrorCode of_machine : {ErrorCode::kUnavailable, ErrorCode::kIo, ErrorCode::kOutOfSpace}) {
    code = of_machine;
    EXPECT_FALSE(verdicts.Of(kOthers, "{}"));
    EXPECT_FALSE(verdicts.Of(kOthers, "{}"));
  }
  EXPECT_EQ(inspected, 9);
}

TEST(Verdicts, WhatIsKeptIsBounded) {
  int inspected = 0;
  Verdicts verdicts(
      [&](const auto&, const auto&) -> Result<std::string> {
        ++inspected;
        return std::string(1000, 'x');
      },
      {.kept_bytes = 4000});
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(verdicts.Of(kFiles, std::to_string(i)));
  ASSERT_TRUE(verdicts.Of(kFiles, "9"));
  EXPECT_EQ(inspected, 10);
  ASSERT_TRUE(verdicts.Of(kFiles, "0"));
  EXPECT_EQ(inspected, 11);
}

TEST(Verdicts, AnInspectionThatThrowsLeavesRoomForTheNext) {
  bool fails = true;
  Verdicts verdicts(
      [&](const auto&, const auto&) -> Result<std::string> {
        if (fails) throw std::runtime_error("out of threads");
        return std::string("good");
      },
      {.at_once = 1, .callers = 1});
  EXPECT_THROW(static_cast<void>(verdicts.Of(kFiles, "{}")), std::runtime_error);
  fails = false;
  EXPECT_EQ(*verdicts.Of(kFiles, "{}"), "good");
}

}  // namespace
}  // namespace skyquilt::server
