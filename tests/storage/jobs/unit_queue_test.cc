#include "storage/jobs/unit_queue.h"

#include <atomic>
#include <thread>
#include <tuple>
#include <utility>

#include "storage/catalogue/trash.h"
#include "storage/db/ids.h"
#include "storage/jobs/unit_inputs.h"
#include "storage/jobs/workers_aside.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {
namespace {

using std::chrono::hours;
using std::chrono::seconds;

class UnitQueueTest : public CatalogueFixture {
 protected:
  Lease CutJob(int count, std::string_view kind = "look") {
    const Lease lease = Begun(catalogue_.AddFlight("field", "{}", now_)->id, now_, R"({"a":1})");
    EXPECT_TRUE(*units_.Cut(lease, kind, count, 100, {0.0, 0.4, "check"}));
    return lease;
  }
  UnitLease Claimed(std::string_view worker = "w") { return **units_.Claim(worker, now_); }

  UnitQueue units_{*db_};
};

TEST_F(UnitQueueTest, AJobWaitsForItsUnitsAndIsThenClaimedAgain) {
  const Lease lease = CutJob(2);
  EXPECT_FALSE(*queue_.Claim("w", now_ + hours(1000)));  // however long it takes
  const UnitLease first = Claimed();
  EXPECT_EQ(std::tie(first.job_id, first.flight_id, first.options, first.kind, first.count, first.items),
            std::tuple(lease.job_id, lease.flight_id, R"({"a":1})", "look", 2, 100));
  const UnitLease second = Claimed();
  EXPECT_NE(first.number, second.number);
  EXPECT_FALSE(*units_.Claim("w", now_));
  EXPECT_TRUE(*units_.Done(second));
  EXPECT_FALSE(*queue_.Claim("w", now_ + seconds(1)));
  EXPECT_DOUBLE_EQ(queue_.Get(lease.job_id)->progress, 0.2);
  EXPECT_EQ(queue_.Get(lease.job_id)->message, "part 1 of 2 is done");
  EXPECT_TRUE(*units_.Done(first));
  EXPECT_FALSE(*units_.Done(first));
  const auto again = test::ValueOf(*queue_.Claim("w", now_ + seconds(1)));
  EXPECT_EQ(again.job_id, lease.job_id);
  EXPECT_EQ(again.attempt, 1);
  EXPECT_EQ(queue_.Get(lease.job_id)->state, JobState::kRunning);
  EXPECT_DOUBLE_EQ(queue_.Get(lease.job_id)->progress, 0.4);
  const std::vector<UnitCount> counts = *units_.Of(lease.job_id);
  ASSERT_EQ(counts.size(), 1U);
  EXPECT_EQ(counts[0].done, 2);
}

TEST_F(UnitQueueTest, AreFoundByTheIndexOfOpenOnes) {
  const auto db = db_->Lock();
  if (db->dialect() != Dialect::kSqlite) GTEST_SKIP() << "PostgreSQL plans by what it finds";
  const std::vector<std::string> plan = test::ValueOf(
      db->All([](const Statement& row) { return row.Get<std::string>(3); },
              "EXPLAIN QUERY PLAN SELECT 1 FROM unit WHERE " + MayBeClaimed("unit", "?1"), ToUs(now_)));
  ASSERT_EQ(plan.size(), 1U);
  EXPECT_NE(plan[0].find("unit_open"), std::string::npos) << plan[0];
}

TEST_F(UnitQueueTest, AreCountedByKindUntilTheirJobEnds) {
  EXPECT_TRUE(units_.Count(now_)->empty());
  CutJob(4);
  const Lease rendered = CutJob(2, "render");
  Claimed();
  EXPECT_TRUE(*units_.Done(Claimed()));
  const std::vector<UnitsOfKind> kinds = *units_.Count(now_);
  ASSERT_EQ(kinds.size(), 2U);
  const UnitsOfKind &look = kinds[0], &render = kinds[1];
  EXPECT_EQ(std::tie(look.kind, look.waiting, look.running, look.done, look.failed_attempts),
            std::tuple("look", 2, 1, 1, 0));
  EXPECT_EQ(std::tie(render.kind, render.waiting), std::tuple("render", 2));
  EXPECT_TRUE(queue_.Cancel(rendered.job_id, now_).ok());
  EXPECT_EQ(units_.Count(now_)->size(), 1U);
}

TEST_F(UnitQueueTest, TellsHowLongTheyWaitAndHowOftenTheyFailed) {
  CutJob(2);
  const auto count = [&] { return units_.Count(now_)->at(0); };
  now_ += seconds(60);
  EXPECT_NEAR(count().longest_waiting_s, 60.0, 5.0);
  const UnitLease first = Claimed("a"), second = Claimed("b");
  EXPECT_EQ(count().waiting, 0);
  EXPECT_EQ(count().longest_waiting_s, 0.0);
  EXPECT_TRUE(*units_.Fail(first, {ErrorCode::kIo, "disk", ""}, true, now_));
  EXPECT_EQ(count().failed_attempts, 1);
  EXPECT_NEAR(count().longest_waiting_s, 0.0, 5.0);
  now_ += kLeaseTime + seconds(40);  // the worker of the second is gone
  EXPECT_EQ(count().waiting, 2);
  EXPECT_EQ(count().running, 0);
  EXPECT_EQ(count().failed_attempts, 2);
  EXPECT_NEAR(count().longest_waiting_s, 55.0, 5.0);  // of the first; the second waits for 40
  EXPECT_TRUE(*units_.GiveBack(Claimed(), now_));
  EXPECT_TRUE(*units_.Done(Claimed()));
  Claimed("c");
  EXPECT_EQ(*units_.ReleaseWorker("c", WorkerEnd::kDied, now_), 1);
  EXPECT_EQ(count().waiting, 1);
  EXPECT_NEAR(count().longest_waiting_s, 0.0, 5.0);
}

TEST_F(UnitQueueTest, WorkersStandAsideForLongerEachTimeUntilTheirWorkGoesWell) {
  EXPECT_EQ(PauseAside(1), seconds(5));
  EXPECT_EQ(PauseAside(2), seconds(10));
  EXPECT_EQ(PauseAside(1'000'000), seconds(600));
  WorkersAside aside(*db_);
  EXPECT_TRUE(aside.List()->empty());
  ASSERT_TRUE(aside.Put("a", 1, {ErrorCode::kOutOfSpace, "full", ""}, now_));
  ASSERT_TRUE(aside.Put("a", 2, {ErrorCode::kIo, "broken", ""}, now_));
  ASSERT_TRUE(aside.Put("b", 1, {ErrorCode::kUnavailable, "away", ""}, now_));
  const auto listed = *aside.List();
  ASSERT_EQ(listed.size(), 2U);
  EXPECT_EQ(listed[0].worker, "a");
  EXPECT_EQ(listed[0].times, 2);
  EXPECT_EQ(listed[0].code, ErrorCodeName(ErrorCode::kIo));
  EXPECT_EQ(listed[0].until - listed[0].since, seconds(10));
  ASSERT_TRUE(aside.Clear("a"));
  EXPECT_EQ(aside.List()->size(), 1U);
  ASSERT_TRUE(aside.Put("b", 1, {ErrorCode::kUnavailable, "away", ""}, now_ - hours(2)));  // nobody came back
  EXPECT_TRUE(aside.List()->empty());
}

TEST_F(UnitQueueTest, TellsWhoHasWhichSinceWhenAtWhichAttempt) {
  const Lease lease = CutJob(3);
  EXPECT_TRUE(units_.Held()->empty());
  const UnitLease first = Claimed("a");
  EXPECT_TRUE(*units_.Fail(first, {ErrorCode::kIo, "disk", ""}, true, now_));
  const UnitLease again = Claimed("b");
  ASSERT_EQ(again.number, first.number);
  Claimed("c");
  const auto held = *units_.Held(lease.job_id);
  ASSERT_EQ(held.size(), 2U);
  EXPECT_EQ(std::tie(held[0].worker, held[0].attempt, held[0].number), std::tuple("b", 2, again.number));
  EXPECT_EQ(std::tie(held[1].worker, held[1].attempt), std::tuple("c", 1));
  EXPECT_NEAR(held[1].held_s, 0.0, 5.0);
  EXPECT_TRUE(*units_.Done(again));
  EXPECT_EQ(units_.Held()->size(), 1U);
  EXPECT_TRUE(units_.Held("another")->empty());
}

TEST_F(UnitQueueTest, TheLeaseOfWhoCutItIsOver) {
  const Lease lease = CutJob(1);
  EXPECT_EQ(*queue_.Renew(lease, now_), LeaseState::kLost);
  EXPECT_FALSE(*queue_.Fail(lease, {ErrorCode::kIo, "late", ""}, true, now_));
  EXPECT_FALSE(*units_.Cut(lease, "look", 3, 1, {}));
  EXPECT_EQ((*units_.Of(lease.job_id))[0].count, 1);
}

TEST_F(UnitQueueTest, AUnitThatIsLostGoesToAnotherWhoAloneMayEndIt) {
  CutJob(1);
  const UnitLease lost = Claimed("a");
  now_ += kLeaseTime + seconds(1);
  const UnitLease next = Claimed("b");
  EXPECT_EQ(*units_.Renew(lost, now_), LeaseState::kLost);
  EXPECT_FALSE(*units_.Done(lost));
  EXPECT_FALSE(*units_.GiveBack(lost, now_));
  EXPECT_FALSE(*units_.Fail(lost, {ErrorCode::kIo, "late", ""}, false, now_));
  EXPECT_EQ(*units_.Renew(next, now_), LeaseState::kHeld);
  EXPECT_TRUE(*units_.Done(next));
}

TEST_F(UnitQueueTest, AWorkerThatIsKnownToBeGoneIsNotWaitedFor) {
  CutJob(1);
  Claimed("a");
  EXPECT_EQ(*units_.ReleaseWorker("b", WorkerEnd::kDied, now_), 0);
  EXPECT_EQ(*units_.ReleaseWorker("a", WorkerEnd::kDied, now_), 1);
  EXPECT_TRUE(*units_.Claim("b", now_));
}

TEST_F(UnitQueueTest, AnInterruptionCostsNoAttemptAndADeathDoes) {
  CutJob(1);
  const auto attempt = [&] { return units_.Held()->at(0).attempt; };
  Claimed("a");
  EXPECT_EQ(*units_.ReleaseWorker("a", WorkerEnd::kInterrupted, now_), 1);
  EXPECT_TRUE(units_.Held()->empty());
  Claimed("a");
  EXPECT_EQ(attempt(), 1);
  EXPECT_EQ(*units_.ReleaseWorker("a", WorkerEnd::kDied, now_), 1);
  Claimed("b");
  EXPECT_EQ(attempt(), 2);
}

TEST_F(UnitQueueTest, DeathOnEveryAttemptFailsTheJob) {
  const Lease lease = CutJob(3);
  for (int attempt = 0; attempt < kMaxUnitAttempts; ++attempt) {
    for (int unit = 0; unit < 3; ++unit) ASSERT_TRUE(*units_.Claim("w", now_));
    now_ += kLeaseTime + seconds(1);
  }
  EXPECT_FALSE(*units_.Claim("w", now_));
  const Job job = *queue_.Get(lease.job_id);
  EXPECT_EQ(job.state, JobState::kFailed);
  ASSERT_TRUE(job.error);
  EXPECT_NE(job.error->message.find("died on every attempt"), std::string::npos);
  EXPECT_TRUE(units_.Of(lease.job_id)->empty());
}

TEST_F(UnitQueueTest, AFailureIsTriedAgainOnlyWhereItMayPass) {
  const Lease lease = CutJob(2);
  EXPECT_TRUE(*units_.Fail(Claimed(), {ErrorCode::kIo, "disk", ""}, true, now_));
  EXPECT_EQ(queue_.Get(lease.job_id)->state, JobState::kRunning);
  const UnitLease again = Claimed();
  const UnitLease other = Claimed();
  EXPECT_TRUE(*units_.GiveBack(again, now_));
  EXPECT_TRUE(*units_.Fail(other, {ErrorCode::kUnprocessable, "no photo", ""}, false, now_));
  const Job job = *queue_.Get(lease.job_id);
  EXPECT_EQ(job.state, JobState::kFailed);
  EXPECT_EQ(job.error->message, "no photo");
  EXPECT_FALSE(*units_.Claim("w", now_));
}

TEST_F(UnitQueueTest, WhatUnitsAreMadeFromTellsThemApart) {
  const std::vector<StoredFile> files{{"a.jpg", "1", 5}, {"b.jpg", "2", 5}};
  const std::string digest = DigestOf({files, "{}", "1.0", 2});
  EXPECT_EQ(digest.size(), 4 + 64U);
  EXPECT_TRUE(digest.starts_with("1.0:"));
  EXPECT_EQ(DigestOf({files, "{}", "1.0", 2}), digest);
  const std::vector<StoredFile> again{{"a.jpg", "1", 5}, {"b.jpg", "3", 5}};  // b was put anew
  const std::vector<StoredFile> swapped{{"a.jpg", "2", 5}, {"b.jpg", "1", 5}};
  const std::vector<StoredFile> run_together{{"a.jpg1", "", 5}, {"b.jpg", "2", 5}};
  for (const std::string& other :
       {DigestOf({again, "{}", "1.0", 2}), DigestOf({swapped, "{}", "1.0", 2}),
        DigestOf({run_together, "{}", "1.0", 2}), DigestOf({files, "{\"a\":1}", "1.0", 2}),
        DigestOf({files, "{}", "1.1", 2}), DigestOf({files, "{}", "1.0", 1})}) {
    EXPECT_NE(other, digest);
  }
}

TEST_F(UnitQueueTest, AJobGoesOnWithTheUnitsOfOneThatFailedAndWasMadeFromTheSame) {
  const std::string flight = catalogue_.AddFlight("field", "{}", now_)->id;
  const std::string other_flight = catalogue_.AddFlight("other", "{}", now_)->id;
  const auto begun = [&](const std::string& of, std::string_view made_from) {
    Lease lease = Begun(of, now_);
    const auto units_of = units_.TakeOver(lease, made_from, now_);
    EXPECT_TRUE(units_of.ok()) << units_of.error().detail;
    return std::pair(lease, **units_of);
  };
  const auto fail = [&](const Lease& lease, ErrorCode code) {
    EXPECT_TRUE(*queue_.Fail(lease, {code, "it fails", ""}, false, now_));
  };
  const auto [first, of_first] = begun(flight, "same");
  EXPECT_EQ(of_first, first.job_id);
  EXPECT_EQ(*units_.UnitsOf(first.job_id), first.job_id);
  fail(first, ErrorCode::kInternal);
  EXPECT_EQ(*queue_.UnitsOfUse(now_), std::vector<std::string>{first.job_id});
  const auto [elsewhere, of_elsewhere] = begun(other_flight, "same");
  EXPECT_EQ(of_elsewhere, elsewhere.job_id);
  ASSERT_TRUE(*queue_.Dismiss(elsewhere, now_));
  EXPECT_EQ(*queue_.UnitsOfUse(now_), std::vector<std::string>{first.job_id});  // nobody wants the other's

  const auto [second, of_second] = begun(flight, "same");
  EXPECT_EQ(of_second, first.job_id);
  // Of three units two are there.
  EXPECT_TRUE(*units_.Cut(second, "look", 3, 100, {0.0, 0.4, "check"}, {0, 2}));
  EXPECT_EQ(queue_.Get(second.job_id)->message, "part 2 of 3 is done");
  const UnitLease left = Claimed();
  EXPECT_EQ(left.number, 1);
  EXPECT_EQ(left.units_of, first.job_id);
  EXPECT_FALSE(*units_.Claim("w", now_));
  EXPECT_TRUE(*units_.Fail(left, {ErrorCode::kUnprocessable, "no photo", ""}, false, now_));

  // It may have failed by what it took over: nobody goes on from there once more.
  EXPECT_TRUE(queue_.UnitsOfUse(now_)->empty());
  const auto [third, of_third] = begun(flight, "same");
  EXPECT_EQ(of_third, third.job_id);
  // Nor where there is damage.
  fail(third, ErrorCode::kCorrupt);
  EXPECT_TRUE(queue_.UnitsOfUse(now_)->empty());
  const auto [fourth, of_fourth] = begun(flight, "same");
  EXPECT_EQ(of_fourth, fourth.job_id);
  // A file that came while it ran is in some of its units.
  ASSERT_TRUE(catalogue_.AddFile(flight, {"late.jpg", NewId(), 1}, now_));
  fail(fourth, ErrorCode::kIo);
  const auto [anew, of_anew] = begun(flight, "same");
  EXPECT_EQ(of_anew, anew.job_id);
  fail(anew, ErrorCode::kIo);
  // Other options.
  const auto [fifth, of_fifth] = begun(flight, "another");
  EXPECT_EQ(of_fifth, fifth.job_id);
  EXPECT_EQ(*queue_.UnitsOfUse(now_), std::vector<std::string>{fifth.job_id});
  fail(fifth, ErrorCode::kIo);
  now_ += kUnitsKept + hours(2);
  EXPECT_TRUE(queue_.UnitsOfUse(now_)->empty());
  const auto [late, of_late] = begun(flight, "another");
  EXPECT_EQ(of_late, late.job_id);
  EXPECT_FALSE(units_.TakeOver(fifth, "another", now_)->has_value());
}

TEST_F(UnitQueueTest, UnitsThatTwoVersionsMadeAreNotTakenOver) {
  const std::string flight = catalogue_.AddFlight("field", "{}", now_)->id;
  const std::vector<StoredFile> none;
  // Of a job whose units were made by a program of `version`.
  const auto failed_by = [&](std::string_view version) {
    const Lease lease = Begun(flight, now_);
    const std::string units_of = **units_.TakeOver(lease, DigestOf({none, "{}", "1.0", 1}), now_);
    EXPECT_TRUE(*units_.Cut(lease, "look", 1, 1, {}));
    const UnitLease unit = Claimed();
    EXPECT_TRUE(units_.MakeAs(unit.job_id, version));
    EXPECT_TRUE(*units_.Fail(unit, {ErrorCode::kUnprocessable, "no photo", ""}, false, now_));
    return std::pair(unit.job_id, units_of);
  };
  const auto [first, of_first] = failed_by("1.0.1");
  EXPECT_EQ(of_first, first);
  const auto [second, of_second] = failed_by("1.0");
  EXPECT_EQ(of_second, second);
  EXPECT_EQ(failed_by("1.0").second, second);
}

TEST_F(UnitQueueTest, AJobWhoseUnitsAreAllThereIsClaimedAtOnce) {
  const Lease lease = Begun(catalogue_.AddFlight("field", "{}", now_)->id, now_);
  EXPECT_EQ(*units_.UnitsOf(lease.job_id), "");
  EXPECT_TRUE(*units_.Cut(lease, "look", 2, 100, {0.0, 0.4, "check"}, {0, 1}));
  EXPECT_EQ(*units_.UnitsOf(lease.job_id), lease.job_id);
  EXPECT_FALSE(*units_.Claim("w", now_));
  EXPECT_EQ(test::ValueOf(*queue_.Claim("w", now_ + seconds(1))).attempt, 1);
}

TEST_F(UnitQueueTest, CancellingEndsTheUnits) {
  const Lease lease = CutJob(2);
  const UnitLease unit = Claimed();
  EXPECT_EQ(queue_.Cancel(lease.job_id, now_)->state, JobState::kDismissed);
  EXPECT_EQ(*units_.Renew(unit, now_), LeaseState::kLost);
  EXPECT_FALSE(*units_.Done(unit));
  EXPECT_FALSE(*units_.Claim("w", now_));
  EXPECT_TRUE(units_.Of(lease.job_id)->empty());
}

TEST_F(UnitQueueTest, TheTrashEndsTheJobAndItsUnits) {
  const Lease lease = CutJob(3);
  const UnitLease at_work = Claimed();
  Trash trash(*db_);
  ASSERT_TRUE(trash.Put(lease.flight_id, now_));
  EXPECT_TRUE(units_.Count(now_)->empty());
  EXPECT_EQ(*units_.Renew(at_work, now_), LeaseState::kLost);
  EXPECT_FALSE(*units_.Done(at_work));
  EXPECT_FALSE(*units_.Claim("w", now_ + hours(1)));
  ASSERT_TRUE(trash.Restore(lease.flight_id));
  EXPECT_EQ(queue_.Get(lease.job_id)->state, JobState::kDismissed);
  EXPECT_TRUE(queue_.Get(lease.job_id)->finished.has_value());
  const auto again = test::ValueOf(queue_.Add(lease.flight_id, "{}", now_));
  EXPECT_EQ((*queue_.Claim("w", now_ + seconds(1)))->job_id, again.id);
}

TEST_F(UnitQueueTest, AJobThatWasCancelledBeforeItIsCutEnds) {
  const Lease lease = Begun(catalogue_.AddFlight("field", "{}", now_)->id, now_);
  EXPECT_EQ(queue_.Cancel(lease.job_id, now_)->state, JobState::kRunning);
  EXPECT_TRUE(*units_.Cut(lease, "look", 3, 100, {0.0, 0.4, "check"}));
  EXPECT_EQ(queue_.Get(lease.job_id)->state, JobState::kDismissed);
  EXPECT_TRUE(queue_.Get(lease.job_id)->finished);
  EXPECT_TRUE(units_.Of(lease.job_id)->empty());
  EXPECT_FALSE(*units_.Claim("w", now_));
  EXPECT_FALSE(*queue_.Claim("w", now_ + hours(1)));
}

TEST_F(UnitQueueTest, ARestartOfTheServerTakesNothingFromAJobThatWaits) {
  const Lease lease = CutJob(1);
  EXPECT_EQ(*queue_.TakeUpAfterRestart(now_), 0);
  EXPECT_FALSE(*queue_.Claim("w", now_ + hours(2)));
  EXPECT_TRUE(*units_.Done(Claimed()));
  EXPECT_EQ(*queue_.TakeUpAfterRestart(now_), 0);
  const auto again = test::ValueOf(*queue_.Claim("w", now_ + seconds(1)));
  EXPECT_EQ(again.attempt, 1);
  // Cut once more: the units it had are done still.
  EXPECT_TRUE(*units_.Cut(again, "look", 1, 100, {0.0, 0.4, "check"}));
  const auto ready = test::ValueOf(*queue_.Claim("w", now_ + seconds(1)));
  EXPECT_TRUE(*units_.Cut(ready, "render", 2, 7, {0.5, 0.9, "render"}));
  EXPECT_EQ(Claimed().kind, "render");
}

TEST_F(UnitQueueTest, ManyWorkersTakeEachUnitOnce) {
  const Lease lease = CutJob(60);
  std::mutex mutex;
  std::set<int> taken;
  std::atomic<int> twice{0};
  std::vector<std::thread> workers;
  for (int worker = 0; worker < 4; ++worker) {
    workers.emplace_back([&, worker] {
      while (true) {
        const auto unit = units_.Claim("w" + std::to_string(worker), now_);
        ASSERT_TRUE(unit.ok());
        if (!*unit) return;
        {
          const std::lock_guard lock(mutex);
          if (!taken.insert((*unit)->number).second) ++twice;
        }
        ASSERT_TRUE(*units_.Done(**unit));
      }
    });
  }
  for (std::thread& worker : workers) worker.join();
  EXPECT_EQ(taken.size(), 60U);
  EXPECT_EQ(twice, 0);
  EXPECT_TRUE(*queue_.Claim("w", now_ + seconds(1)));
  EXPECT_EQ(lease.attempt, 1);
}

}  // namespace
}  // namespace skyquilt::storage
