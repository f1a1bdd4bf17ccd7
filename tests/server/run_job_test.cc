#include "server/workers/run_job.h"

#include <gtest/gtest.h>

#include "server/units/cut_job.h"
#include "tests/server/worker_test.h"

namespace skyquilt::server {
namespace {

using storage::Now;

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

TEST_F(RunJobTest, AMapWhoseHeightsAreMatchedIsMadeByOneWorker) {
  storage::Lease lease = Claimed();
  lease.options = R"({"surface":"dense"})";
  EXPECT_EQ(CutOf(context_, lease)->step, CutStep::kWhole);
  lease.options = R"({"heights":"dsm"})";
  EXPECT_EQ(CutOf(context_, lease)->step, CutStep::kWhole);
  lease.options = R"({"surface":"smooth"})";
  EXPECT_EQ(CutOf(context_, lease)->step, CutStep::kLook);
}

}  // namespace
}  // namespace skyquilt::server
