// Whose job comes next, and how long it should take.
#include <chrono>
#include <random>
#include <vector>

#include "storage/catalogue/stage_costs.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {
namespace {

using std::chrono::seconds;

class TurnsTest : public CatalogueFixture {
 protected:
  std::string Ask(const std::string& owner, int priority = 0) {
    const std::string flight = catalogue_.AddFlight("field", "{}", now_, owner)->id;
    return queue_.Add(flight, "{}", now_, {priority, owner})->id;
  }
  Lease Next() {
    now_ += seconds(1);
    return **queue_.Claim("w", now_);
  }
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
    owners += *db->Text("SELECT owner FROM flight WHERE id=?", flight);
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
    ASSERT_TRUE(
        costs.Add({"job" + std::to_string(i), 50, {{"align", 0.75 * total_s}, {"render", 0.25 * total_s}}}));
  }
  const auto expectation = test::ValueOf(ExpectationFrom(*costs.Latest(20), 100));
  EXPECT_NEAR(expectation.total_s, 140.0, 1e-6);
  EXPECT_LT(expectation.low_s, 110.0);
  EXPECT_GT(expectation.high_s, 165.0);
  for (const auto& [stage, share] : expectation.shares)
    EXPECT_NEAR(share, stage == "align" ? 0.75 : 0.25, 1e-9);
  EXPECT_EQ(costs.Latest(3)->size(), 3u);
}

// What the order is, said plainly: every waiting job against every other.
std::string NextByLookingAtAll(CatalogueDb& catalogue, Time now) {
  const auto db = catalogue.Lock();
  return *db->Text(
      "SELECT id FROM job w WHERE (state='accepted' AND not_before_us<=?1) OR (state='running' AND"
      " lease_until_us<?1 AND cancel=0 AND attempts<max_attempts) ORDER BY priority DESC,"
      " (SELECT count(*) FROM job r WHERE r.owner=w.owner AND r.state='running' AND r.lease_until_us>=?1),"
      " (SELECT coalesce(max(s.attempt_started_us),0) FROM job s WHERE s.owner=w.owner), id LIMIT 1",
      ToUs(now));
}

TEST_F(TurnsTest, AreThoseThatLookingAtEveryJobFinds) {
  std::mt19937 random(7);
  const auto pick = [&](int below) { return static_cast<int>(random() % static_cast<unsigned>(below)); };
  const std::vector<std::string> owners = {"", "a", "b", "c", "d", "e"};
  std::vector<Lease> held;
  int claimed = 0;
  for (int step = 0; step < 600; ++step) {
    now_ += seconds(pick(4));
    const int what = pick(10);
    if (what < 4) {
      Ask(owners[static_cast<std::size_t>(pick(6))], pick(3));
    } else if (what < 7) {
      const std::string expected = NextByLookingAtAll(*db_, now_);
      const auto lease = *queue_.Claim("w", now_);
      ASSERT_EQ(lease ? lease->job_id : "", expected) << step;
      if (lease) held.push_back(*lease);
      if (lease) ++claimed;
    } else if (!held.empty()) {
      const auto which = held.begin() + pick(static_cast<int>(held.size()));
      const Lease lease = *which;
      held.erase(which);  // and with `what` 9 it is left to run out
      if (what == 7) static_cast<void>(queue_.Fail(lease, {ErrorCode::kIo, "x", ""}, pick(2) == 0, now_));
      if (what == 8) static_cast<void>(queue_.GiveBack(lease, now_));
    }
    // A flight goes whose job nobody has begun: others take the time of their owner's last turn with them.
    if (pick(20) == 0) {
      const auto db = db_->Lock();
      ASSERT_TRUE(
          db->Exec("DELETE FROM flight WHERE id=(SELECT flight_id FROM job WHERE state='accepted' AND"
                   " attempt_started_us IS NULL ORDER BY id DESC LIMIT 1)"));
    }
    if (pick(12) == 0) {
      const auto waiting = *queue_.UnfinishedJobs();
      if (!waiting.empty()) {
        static_cast<void>(
            queue_.Cancel(waiting[static_cast<std::size_t>(pick(static_cast<int>(waiting.size())))], now_));
      }
    }
  }
  EXPECT_GT(claimed, 100);
  const auto db = db_->Lock();
  if (TestsPostgres()) {
    // Nobody who waits is missing from the table of turns, nor comes in it later than he should.
    const auto wrong = db->Number(
        "SELECT count(*) FROM job j LEFT JOIN turn t ON t.owner=j.owner AND t.priority=j.priority"
        " WHERE j.state='accepted' AND (t.owner IS NULL OR t.first_id>j.id OR t.last_us>"
        " (SELECT coalesce(max(s.attempt_started_us),0) FROM job s WHERE s.owner=j.owner))");
    EXPECT_EQ(*wrong, 0);
    return;
  }
  // The table of turns says what the jobs say.
  const auto wrong = db->Number(
      "SELECT count(*) FROM (SELECT owner, priority, waiting, first_id FROM turn EXCEPT SELECT owner, priority,"
      " count(*), min(id) FROM job WHERE state='accepted' GROUP BY owner, priority)");
  EXPECT_EQ(*wrong, 0);
  const auto missing = db->Number(
      "SELECT (SELECT count(*) FROM turn) = (SELECT count(*) FROM (SELECT 1 FROM job WHERE state='accepted'"
      " GROUP BY owner, priority))");
  EXPECT_EQ(*missing, 1);
}

TEST_F(TurnsTest, AreFoundWithoutLookingAtAllWhoWait) {
  constexpr int kMany = 3000;
  {
    const auto db = db_->Lock();
    auto transaction = test::ValueOf(Transaction::Begin(*db));
    auto flights = *db->Prepare("INSERT INTO flight(id,name,created_us) VALUES(?,'x',0)");
    auto jobs =
        *db->Prepare("INSERT INTO job(id,flight_id,state,created_us,owner) VALUES(?,?,'accepted',0,?)");
    for (int i = 1; i <= kMany; ++i) {
      const std::string number = std::to_string(1'000'000 + i).substr(1);
      const std::string owner = i % 2 == 0 ? "one" : "o" + std::to_string(i);
      const std::string flight = "f" + number;
      const std::string job = "j" + number;
      ASSERT_TRUE(flights.Bind(1, flight).Run());
      ASSERT_TRUE(jobs.Bind(1, job).Bind(2, flight).Bind(3, owner).Run());
    }
    ASSERT_TRUE(transaction.Commit());
  }
  std::vector<std::string> first;
  for (int i = 0; i < 50; ++i) first.push_back(Next().job_id);
  EXPECT_EQ(first[0], "j000001");
  EXPECT_EQ(first[1], "j000002");  // of the one who has many, once
  EXPECT_EQ(first[2], "j000003");
  EXPECT_EQ(first[3], "j000005");
}

}  // namespace
}  // namespace skyquilt::storage
