// Whose job comes next, and how long it should take.
#include <gtest/gtest.h>

#include "storage/job_queue.h"
#include "storage/stage_costs.h"
#include "tests/storage/scratch_dir.h"

namespace skyquilt::storage {
namespace {

using std::chrono::seconds;

class TurnsTest : public testing::Test {
 protected:
  TurnsTest() : db_(*CatalogueDb::Open(dir_.path() / "catalogue.db")), catalogue_(*db_), queue_(*db_), now_(Now()) {}

  std::string Ask(const std::string& owner, int priority = 0) {
    const std::string flight = catalogue_.AddFlight("field", "{}", now_, owner)->id;
    return queue_.Add(flight, "{}", now_, {priority, owner})->id;
  }
  Lease Next() {
    now_ += seconds(1);
    return **queue_.Claim("w", now_);
  }

  ScratchDir dir_;
  std::unique_ptr<CatalogueDb> db_;
  Catalogue catalogue_;
  JobQueue queue_;
  Time now_;
};

TEST_F(TurnsTest, OneWhoAsksForManyDoesNotKeepOthersWaiting) {
  std::vector<std::string> many;
  for (int i = 0; i < 5; ++i) many.push_back(Ask("eager"));
  const std::string late = Ask("modest");
  EXPECT_EQ(Next().job_id, many[0]);
  EXPECT_EQ(Next().job_id, late);  // while the first still runs
  EXPECT_EQ(Next().job_id, many[1]);
  // And where only one runs at a time, they take turns.
  const std::string again = Ask("modest");
  EXPECT_EQ(Next().job_id, again);
}

TEST_F(TurnsTest, ThoseWhoWaitTakeTurnsWhenOneWorkerServesAll) {
  std::vector<std::string> served;
  for (const char* owner : {"a", "a", "a", "b", "b", "c"}) Ask(owner);
  for (int i = 0; i < 6; ++i) {
    const Lease lease = Next();
    served.push_back(*catalogue_.HasFlight(lease.flight_id) ? lease.flight_id : "");
    ASSERT_TRUE(*queue_.Fail(lease, {ErrorCode::kUnprocessable, "x", ""}, false, now_));
  }
  std::string owners;
  for (const std::string& flight : served) {
    const auto db = db_->Lock();
    auto query = *db->Prepare("SELECT owner FROM flight WHERE id=?");
    ASSERT_TRUE(*query.Bind(1, flight).Step());
    owners += query.ColumnText(0);
  }
  EXPECT_EQ(owners, "abcaba");
}

TEST_F(TurnsTest, AHigherPriorityComesFirst) {
  Ask("a");
  Ask("b", -1);
  const std::string urgent = Ask("a", 5);
  EXPECT_EQ(Next().job_id, urgent);
  EXPECT_EQ(queue_.Get(urgent)->priority, 5);
}

TEST_F(TurnsTest, OnlyEndedJobsAreForgotten) {
  const std::string id = Ask("a");
  EXPECT_EQ(queue_.Remove(id).error().code, ErrorCode::kConflict);
  ASSERT_TRUE(queue_.Cancel(id, now_));
  EXPECT_TRUE(queue_.Remove(id));
  EXPECT_EQ(queue_.Get(id).error().code, ErrorCode::kNotFound);
}

TEST_F(TurnsTest, BytesCountForTheOneWhoseFlightHoldsThem) {
  const std::string flight = catalogue_.AddFlight("f", "{}", now_, "a")->id;
  ASSERT_TRUE(catalogue_.AddFile(flight, {"1.jpg", "s1", 700}, now_));
  ASSERT_TRUE(catalogue_.AddFile(catalogue_.AddFlight("f", "{}", now_, "b")->id, {"1.jpg", "s2", 50}, now_));
  EXPECT_EQ(*catalogue_.BytesOf("a"), 700);
  ASSERT_TRUE(catalogue_.DeleteFlight(flight));
  EXPECT_EQ(*catalogue_.BytesOf("a"), 0);
}

TEST_F(TurnsTest, WhatJobsTookSaysWhatTheNextWillTake) {
  StageCosts costs(*db_);
  EXPECT_FALSE(ExpectationFrom(*costs.Latest(10), 100));
  for (int i = 0; i < 9; ++i) {
    // 1.0 to 1.8 s a photo, three quarters of it to align.
    const double total_s = 50.0 * (1.0 + 0.1 * i);
    ASSERT_TRUE(costs.Add({"job" + std::to_string(i), 50, {{"align", 0.75 * total_s}, {"render", 0.25 * total_s}}}));
  }
  const auto expectation = ExpectationFrom(*costs.Latest(20), 100);
  ASSERT_TRUE(expectation);
  EXPECT_NEAR(expectation->total_s, 140.0, 1e-6);
  EXPECT_LT(expectation->low_s, 110.0);
  EXPECT_GT(expectation->high_s, 165.0);
  for (const auto& [stage, share] : expectation->shares) EXPECT_NEAR(share, stage == "align" ? 0.75 : 0.25, 1e-9);
  EXPECT_EQ(costs.Latest(3)->size(), 3u);
}

}  // namespace
}  // namespace skyquilt::storage
