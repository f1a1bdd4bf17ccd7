// What a worker does with a job, and how it tells the queue of an end.
#include "server/workers/run_job.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <memory>

#include "core/flight/remarks/because.h"
#include "server/jobs/job_task.h"
#include "server/units/cut_job.h"
#include "server/units/end_of_work.h"
#include "server/units/run_unit.h"
#include "storage/blobs/folder_blobs.h"
#include "storage/folder/sweep.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::server {
namespace {

using storage::Now;

// What a worker has to work with, over a data folder and a catalogue of the test's own.
class WorkerTest : public testing::Test {
 protected:
  // As another process, on another machine.
  WorkerContext Worker() {
    WorkerContext context{dir_, blobs_, catalogue_, queue_, costs_, units_, is_stopping_};
    context.is_shared = true;
    return context;
  }
  storage::Lease Claimed() { return **queue_.Claim("w", storage::Now()); }

  test::TemporaryFolder folder_;
  storage::DataDir dir_ = *storage::DataDir::Open(folder_.path() / "data");
  std::unique_ptr<storage::CatalogueDb> db_ = *storage::CatalogueDb::Open(folder_.path() / "catalogue.db");
  storage::FolderBlobs blobs_{folder_.path() / "data"};
  storage::Catalogue catalogue_{*db_};
  storage::JobQueue queue_{*db_};
  storage::StageCosts costs_{*db_};
  storage::UnitQueue units_{*db_};
  std::atomic<bool> is_stopping_ = false;
};

class RunJobTest : public WorkerTest {
 protected:
  void SetUp() override {
    for (const char* name : {"a.jpg", "b.jpg", "c.jpg"})
      ASSERT_TRUE(catalogue_.AddFile(flight_, {name, name, 5}, Now()));
    ASSERT_TRUE(queue_.Add(flight_, "{}", Now()));
    context_.cut_above_files = 2;
  }

  const std::string flight_ = catalogue_.AddFlight("field", "{}", Now())->id;
  WorkerContext context_ = Worker();
};

// It was made whole then, by one worker, whatever its size.
TEST_F(RunJobTest, WhereTheCatalogueDoesNotSayWhetherAJobIsCutItIsGivenBackAndNotMade) {
  const storage::Lease lease = Claimed();
  EXPECT_EQ(CutOf(context_, lease)->step, CutStep::kLook);
  storage::Lease before = lease;
  before.token = 0;
  const std::filesystem::path earlier = dir_.Work() / storage::WorkName(before);
  std::filesystem::create_directories(earlier);
  ASSERT_TRUE(db_->Lock()->Exec("ALTER TABLE unit RENAME TO away"));
  ASSERT_FALSE(CutOf(context_, lease));
  RunJob(context_, lease);
  ASSERT_TRUE(context_.fault);
  EXPECT_EQ(context_.fault->code, ErrorCode::kUnavailable);
  EXPECT_EQ(queue_.Get(lease.job_id)->state, storage::JobState::kAccepted);
  EXPECT_TRUE(std::filesystem::exists(earlier));  // the next attempt goes on from there

  ASSERT_TRUE(db_->Lock()->Exec("ALTER TABLE away RENAME TO unit"));
  const storage::Lease next = Claimed();
  EXPECT_EQ(next.attempt, 1);
  RunJob(context_, next);
  EXPECT_EQ((*units_.Of(lease.job_id)).at(0).count, 1);
}

TEST_F(RunJobTest, WhatAStopCutsOffTheNextStartGoesOnFrom) {
  context_.is_shared = false;
  context_.cut_above_files = 0;
  const storage::Lease lease = Claimed();
  const std::filesystem::path state = dir_.Work() / storage::WorkName(lease) / "mosaic.state";
  std::filesystem::create_directories(state.parent_path());
  std::ofstream(state) << "blocks";
  is_stopping_ = true;
  RunJob(context_, lease);
  EXPECT_EQ(queue_.Get(lease.job_id)->state, storage::JobState::kAccepted);
  EXPECT_TRUE(std::filesystem::exists(state));

  EXPECT_EQ(storage::SweepWork(dir_, queue_, Now())->removed, 0);
  ASSERT_TRUE(queue_.Cancel(lease.job_id, Now()));
  EXPECT_EQ(storage::SweepWork(dir_, queue_, Now())->removed, 1);
}

TEST_F(RunJobTest, SoItIsWithAPartOfALargeFlight) {
  context_.is_shared = false;
  RunJob(context_, Claimed());
  const storage::UnitLease unit = **units_.Claim("w", Now());
  is_stopping_ = true;
  RunUnit(context_, unit);
  EXPECT_TRUE(*units_.Claim("w", Now()));
  const std::filesystem::path parts = dir_.Work() / storage::UnitsWorkName(unit.units_of);
  const auto of_attempt = [](const auto& entry) {
    return entry.path().filename().string().starts_with("look-0.");
  };
  EXPECT_TRUE(std::any_of(std::filesystem::directory_iterator(parts), std::filesystem::directory_iterator(),
                          of_attempt));
}

TEST_F(RunJobTest, AMachineOfWorkersAloneKeepsNothingOfJobsThatEnded) {
  const storage::Lease ended = Claimed();
  const std::filesystem::path left = dir_.Work() / storage::WorkName(ended);
  std::filesystem::create_directories(left);
  ASSERT_TRUE(queue_.Dismiss(ended, Now()));
  ASSERT_TRUE(queue_.Add(flight_, "{}", Now()));
  is_stopping_ = true;
  RunJob(context_, Claimed());
  EXPECT_FALSE(std::filesystem::exists(left));
}

TEST_F(RunJobTest, AMapWhoseHeightsAreMatchedIsMadeByOneWorker) {
  storage::Lease lease = Claimed();
  lease.options = R"({"surface":"dense"})";
  EXPECT_EQ(CutOf(context_, lease)->step, CutStep::kWhole);
  lease.options = R"({"heights":"dsm"})";
  EXPECT_EQ(CutOf(context_, lease)->step, CutStep::kWhole);
  lease.options = R"({"surface":"smooth"})";
  EXPECT_EQ(CutOf(context_, lease)->step, CutStep::kLook);
}

TEST_F(RunJobTest, APartThatCannotBeStoredSaysWhyAsAMapDoes) {
  std::ofstream(dir_.Work() / storage::UnitsWorkName("j")) << "no folder";
  const auto made = MakeOutFolder(context_, "j", UnitKind::kLook, 0);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kIo);
  EXPECT_EQ(flight::WhyOf(made.error()), flight::Remark(flight::RemarkCode::kFailNotStored));
  EXPECT_EQ(MapNotStored("make a folder", ENOSPC).code, ErrorCode::kOutOfSpace);
}

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
