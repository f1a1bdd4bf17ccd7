#include "server/units/end_of_work.h"

#include <gtest/gtest.h>

#include "tests/server/worker_test.h"

namespace skyquilt::server {
namespace {

using storage::Now;

class EndOfWork : public WorkerTest {
 protected:
  const Error full_{ErrorCode::kOutOfSpace, "The disk is full.", ""};
};

TEST_F(EndOfWork, AJobThatNoMachineBearsCostsAttemptsAlsoWhereEachWorkerDoesOneAlone) {
  const std::string flight = catalogue_.AddFlight("field", "{}", Now())->id;
  ASSERT_TRUE(queue_.Add(flight, "{}", Now()));
  for (int worker = 0; worker < storage::kFreeTroubles; ++worker) {
    WorkerContext context = Worker();
    const storage::Lease lease = Claimed();
    EXPECT_EQ(lease.attempt, 1);
    ASSERT_TRUE(IsGivenBack(context, queue_, lease, full_)) << worker;
    EXPECT_EQ(context.fault->code, ErrorCode::kOutOfSpace);
    ASSERT_TRUE(*queue_.GiveBack(lease, Now()));
  }
  WorkerContext context = Worker();
  EXPECT_FALSE(IsGivenBack(context, queue_, Claimed(), full_));
  EXPECT_TRUE(context.fault);  // the machine stands aside all the same
  EXPECT_TRUE(MayRetry(context, full_.code));
  EXPECT_FALSE(MayRetry(context, ErrorCode::kUnprocessable));
  context.is_shared = false;
  EXPECT_FALSE(MayRetry(context, full_.code));  // one machine alone says at once what to do
}

TEST_F(EndOfWork, UnitsAreCountedEachForItself) {
  const std::string flight = catalogue_.AddFlight("field", "{}", Now())->id;
  ASSERT_TRUE(queue_.Add(flight, "{}", Now()));
  ASSERT_TRUE(*units_.Cut(Claimed(), "look", 2, 10, {}));
  const storage::UnitLease first = **units_.Claim("a", Now()), second = **units_.Claim("b", Now());
  WorkerContext context = Worker();
  for (int i = 0; i < storage::kFreeTroubles; ++i)
    EXPECT_TRUE(IsGivenBack(context, units_, first, full_)) << i;
  EXPECT_FALSE(IsGivenBack(context, units_, first, full_));
  EXPECT_TRUE(IsGivenBack(context, units_, second, full_));
  ASSERT_TRUE(*units_.Done(second));
  EXPECT_EQ(*units_.CountTrouble(second), 0);  // the lease is over
}

TEST_F(EndOfWork, AnEndThatNobodyHeardIsRememberedWhereOthersShareTheQueue) {
  WorkerContext context = Worker();
  int told = 0;
  TellUntilHeard(context, "j", [&]() -> Result<bool> {
    if (++told > 1) return false;  // the lease was lost: that is an answer
    return Error{ErrorCode::kUnavailable, "The database is away.", ""};
  });
  EXPECT_EQ(told, 2);
  EXPECT_FALSE(context.may_hold);
  TellUntilHeard(context, "j", []() -> Result<bool> {
    return Error{ErrorCode::kUnavailable, "The database is away.", ""};
  });
  EXPECT_TRUE(context.may_hold);
}

TEST_F(EndOfWork, WhatTheInputCausesAndWhatOneMachineHasAloneIsNotGivenBack) {
  const std::string flight = catalogue_.AddFlight("field", "{}", Now())->id;
  ASSERT_TRUE(queue_.Add(flight, "{}", Now()));
  const storage::Lease lease = Claimed();
  WorkerContext context = Worker();
  for (const ErrorCode code : {ErrorCode::kUnprocessable, ErrorCode::kCorrupt, ErrorCode::kInternal})
    EXPECT_FALSE(IsGivenBack(context, queue_, lease, {code, "", ""}));
  EXPECT_FALSE(context.fault);
  context.is_shared = false;
  EXPECT_FALSE(IsGivenBack(context, queue_, lease, full_));
  EXPECT_FALSE(context.fault);
  EXPECT_EQ(*queue_.CountTrouble(lease), 1);
  ASSERT_TRUE(*queue_.GiveBack(lease, Now()));
  EXPECT_EQ(*queue_.CountTrouble(lease), 0);
}

}  // namespace
}  // namespace skyquilt::server
