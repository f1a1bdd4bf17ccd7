#include "server/jobs/job_progress.h"

#include <gtest/gtest.h>

#include "storage/catalogue/event_log.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::server {
namespace {

using std::chrono::milliseconds;

template <typename Condition>
bool Eventually(Condition condition) {
  for (int i = 0; i < 400; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(milliseconds(25));
  }
  return false;
}

class JobProgressTest : public testing::Test {
 protected:
  JobProgressTest()
      : db_(*storage::CatalogueDb::Open(dir_.path() / "catalogue.db")), catalogue_(*db_), queue_(*db_) {
    flight_ = catalogue_.AddFlight("f", "{}", storage::Now())->id;
    job_ = queue_.Add(flight_, "{}", storage::Now())->id;
    lease_ = **queue_.Claim("w", storage::Now());
  }
  test::TemporaryFolder dir_;
  std::unique_ptr<storage::CatalogueDb> db_;
  storage::Catalogue catalogue_;
  storage::JobQueue queue_;
  std::string flight_;
  std::string job_;
  storage::Lease lease_;
  std::atomic<bool> is_stopping_ = false;
};

TEST(WholeJobFraction, GrowsThroughTheStages) {
  double before = -1.0;
  for (const char* stage :
       {"read", "check", "pose", "align", "ground", "plan", "expose", "seam", "render", "export"}) {
    EXPECT_GT(WholeJobFraction(UsualShares(), stage, 0.5), before) << stage;
    EXPECT_LE(WholeJobFraction(UsualShares(), stage, 0.0), WholeJobFraction(UsualShares(), stage, 1.0));
    before = WholeJobFraction(UsualShares(), stage, 0.5);
  }
  EXPECT_NEAR(WholeJobFraction(UsualShares(), "export", 1.0), 1.0, 1e-9);
  EXPECT_EQ(WholeJobFraction(UsualShares(), "unknown", 0.5), 0.0);
}

TEST(WholeJobFraction, CountsHeightsWhereTheyAreMatched) {
  EXPECT_NEAR(WholeJobFraction(UsualShares(JobKind::kUpright), "export", 1.0), 1.0, 1e-9);
  EXPECT_NEAR(WholeJobFraction(UsualShares(JobKind::kWithHeights), "surface", 1.0), 1.0, 1e-9);
  for (const StageShares& shares : {UsualShares(JobKind::kUpright), UsualShares(JobKind::kWithHeights)})
    EXPECT_GT(WholeJobFraction(shares, "surface", 1.0), WholeJobFraction(shares, "surface", 0.0) + 0.3);
}

TEST(WholeJobFraction, GoesByWhatWasMeasured) {
  const StageShares shares = SharesOf({60.0, 50.0, 70.0, {{"align", 0.75}, {"render", 0.25}}});
  EXPECT_NEAR(WholeJobFraction(shares, "align", 1.0), 0.75, 1e-9);
  EXPECT_NEAR(WholeJobFraction(shares, "render", 0.5), 0.875, 1e-9);
  EXPECT_NEAR(WholeJobFraction(shares, "export", 1.0), 1.0, 1e-9);
}

TEST_F(JobProgressTest, WritesStageAndFractionThatNeverGoBack) {
  JobProgress progress(queue_, lease_, is_stopping_);
  progress.BeginStage("render");
  progress.Report(0.5, "half");
  EXPECT_TRUE(Eventually([&] { return queue_.Get(job_)->message == "half"; }));
  const double reached = queue_.Get(job_)->progress;
  EXPECT_GT(reached, 0.5);
  EXPECT_EQ(queue_.Get(job_)->stage, "render");
  progress.BeginStage("warp");
  progress.Report(0.1, "unknown stage");
  EXPECT_TRUE(Eventually([&] { return queue_.Get(job_)->message == "unknown stage"; }));
  EXPECT_EQ(queue_.Get(job_)->progress, reached);
  EXPECT_FALSE(progress.IsCancelled());
}

TEST_F(JobProgressTest, TellsOfEveryStageHoweverShort) {
  JobProgress progress(queue_, lease_, is_stopping_);
  progress.BeginStage("read");
  progress.BeginStage("align");
  progress.Report(1.0, "all pairs");
  progress.BeginStage("render");
  ASSERT_TRUE(Eventually([&] { return queue_.Get(job_)->stage == "render"; }));
  std::string told;
  const auto events = test::ValueOf(storage::EventLog(*db_).After(0, {flight_, std::nullopt}, 100));
  for (const storage::Event& event : events) told += event.body;
  for (const char* word : {"\"read\"", "\"align\"", "\"render\""}) {
    EXPECT_NE(told.find(word), std::string::npos) << word << " in " << told;
  }
}

TEST_F(JobProgressTest, StagesWithoutEndDoNotKeepTheQueueBusy) {
  JobProgress progress(queue_, lease_, is_stopping_);
  for (int i = 0; i < 20'000; ++i) progress.BeginStage("stage" + std::to_string(i));
  EXPECT_TRUE(Eventually([&] { return queue_.Get(job_)->stage == "stage19999"; }));
  const auto events = test::ValueOf(storage::EventLog(*db_).After(0, {flight_, std::nullopt}, 20'000));
  EXPECT_LT(events.size(), 1000u);
}

TEST_F(JobProgressTest, SeesTheWishToCancel) {
  JobProgress progress(queue_, lease_, is_stopping_);
  ASSERT_TRUE(queue_.Cancel(job_, storage::Now()));
  EXPECT_TRUE(Eventually([&] { return progress.IsCancelled(); }));
  EXPECT_EQ(progress.lease_state(), storage::LeaseState::kCancelRequested);
}

TEST_F(JobProgressTest, SeesALostLeaseAndADeletedFlight) {
  JobProgress progress(queue_, lease_, is_stopping_);
  ASSERT_TRUE(catalogue_.DeleteFlight(flight_));
  EXPECT_TRUE(Eventually([&] { return progress.IsCancelled(); }));
  EXPECT_EQ(progress.lease_state(), storage::LeaseState::kLost);
}

TEST_F(JobProgressTest, GoesOnUnheardForAsLongAsItIsTold) {
  JobProgress patient(queue_, lease_, is_stopping_, UsualShares(), {}, std::chrono::hours(1));
  ASSERT_TRUE(db_->Lock()->Exec("ALTER TABLE job RENAME TO job_away"));
  {
    JobProgress hasty(queue_, lease_, is_stopping_, UsualShares(), {}, std::chrono::seconds(0));
    EXPECT_TRUE(Eventually([&] { return hasty.lease_state() == storage::LeaseState::kLost; }));
  }
  EXPECT_FALSE(patient.IsCancelled());
  ASSERT_TRUE(db_->Lock()->Exec("ALTER TABLE job_away RENAME TO job"));
  const auto is_heard = [&] {
    patient.Report(0.5, "heard again");
    return queue_.Get(job_)->message == "heard again";
  };
  EXPECT_TRUE(Eventually(is_heard));
  EXPECT_FALSE(patient.IsCancelled());
}

TEST_F(JobProgressTest, StopsWithItsWorker) {
  JobProgress progress(queue_, lease_, is_stopping_);
  EXPECT_FALSE(progress.IsCancelled());
  is_stopping_ = true;
  EXPECT_TRUE(progress.IsCancelled());
  EXPECT_EQ(progress.lease_state(), storage::LeaseState::kHeld);
}

}  // namespace
}  // namespace skyquilt::server
