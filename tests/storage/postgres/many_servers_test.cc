// Many servers and workers on one catalogue in PostgreSQL. Skipped where SKYQUILT_TEST_POSTGRES names no
// server; tests/storage/CMakeLists.txt runs it with one.
#include <algorithm>
#include <atomic>
#include <mutex>
#include <random>

#include "storage/catalogue/event_log.h"
#include "storage/catalogue/previews.h"
#include "storage/catalogue/trash.h"
#include "storage/catalogue/webhooks.h"
#include "storage/db/ids.h"
#include "storage/jobs/job_queue.h"
#include "storage/jobs/unit_queue.h"
#include "tests/storage/postgres/postgres_fixture.h"

namespace skyquilt::storage {
namespace {

using std::chrono::hours;
using std::chrono::seconds;

TEST_F(PostgresTest, LeasesHaveTheirTimeOnceMoreAfterTheServerWasDown) {
  JobQueue queue(*db_);
  ASSERT_TRUE(queue.Add(NewFlight(), "{}", Now()));
  const Lease lease = **queue.Claim("worker-7", Now());
  // It ran out, and the server began a moment ago.
  const Time begun =
      FromUs(Number("SELECT CAST(extract(epoch FROM pg_postmaster_start_time())*1000000 AS BIGINT)"));
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE job SET lease_until_us=" + std::to_string(ToUs(begun) - 1)));
  EXPECT_FALSE(queue.Claim("w", begun + seconds(2))->has_value());
  EXPECT_EQ(*queue.Renew(lease, begun + seconds(3)), LeaseState::kHeld);
  EXPECT_TRUE(queue.Claim("w", Now() + seconds(20) + kLeaseTime)->has_value());
}

TEST_F(PostgresTest, UnitsHaveTheirTimeOnceMoreAfterTheServerWasDown) {
  JobQueue queue(*db_);
  UnitQueue units(*db_);
  ASSERT_TRUE(queue.Add(NewFlight(), "{}", Now()));
  ASSERT_TRUE(*units.Cut(**queue.Claim("w", Now()), "look", 2, 10, {}));
  const UnitLease held = **units.Claim("worker-7", Now());
  const UnitLease released = **units.Claim("worker-8", Now());
  ASSERT_EQ(*units.ReleaseWorker("worker-8", WorkerEnd::kDied, Now()), 1);
  const Time begun =
      FromUs(Number("SELECT CAST(extract(epoch FROM pg_postmaster_start_time())*1000000 AS BIGINT)"));
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE unit SET lease_until_us=" + std::to_string(ToUs(begun) - 1) +
                                " WHERE worker='worker-7'"));
  EXPECT_EQ((*units.Claim("w", begun + seconds(2)))->number, released.number);
  EXPECT_FALSE(units.Claim("w", begun + seconds(2))->has_value());
  EXPECT_EQ(*units.Renew(held, begun + seconds(3)), LeaseState::kHeld);
  EXPECT_TRUE(units.Claim("w", Now() + seconds(20) + kLeaseTime)->has_value());
}

TEST_F(PostgresTest, WhatLayBeforeAFrozenServerIsStillWorthItsTime) {
  JobQueue queue(*db_);
  UnitQueue units(*db_);
  const auto said = [] { return Now() - seconds(25); };
  const auto soon = [] { return Now() + seconds(3); };
  ASSERT_TRUE(queue.Add(NewFlight(), "{}", said()));
  const Lease lease = **queue.Claim("w", said() + seconds(20));
  EXPECT_FALSE(queue.Claim("other", soon())->has_value());
  EXPECT_EQ(*queue.Renew(lease, said()), LeaseState::kHeld);
  EXPECT_FALSE(queue.Claim("other", soon())->has_value());
  ASSERT_TRUE(*units.Cut(lease, "look", 1, 10, {}));
  const UnitLease unit = **units.Claim("w", said());
  EXPECT_FALSE(units.Claim("other", soon())->has_value());
  EXPECT_EQ(*units.Renew(unit, said()), LeaseState::kHeld);
  EXPECT_FALSE(units.Claim("other", soon())->has_value());
}

TEST_F(PostgresTest, EventsAppearInTheOrderOfTheirNumbers) {
  // Two writers at once: whoever reads up to the latest number has missed none below it.
  constexpr int kEach = 60;
  std::atomic<bool> is_over = false;
  std::vector<std::thread> writers;
  for (int w = 0; w < 3; ++w) {
    writers.emplace_back([&] {
      const auto own = *OpenTestCatalogue(path());
      Catalogue catalogue(*own);
      const std::string flight = catalogue.AddFlight("f", "{}", Now())->id;
      for (int i = 0; i < kEach; ++i) {
        ASSERT_TRUE(catalogue.AddFile(flight, {std::to_string(i), NewId(), 1}, Now()));
      }
    });
  }
  std::int64_t tail = 0;
  std::size_t seen = 0;
  std::thread reader([&] {
    const EventLog log(*db_);
    for (bool last = false; !last;) {
      last = is_over;
      const auto events = log.After(tail, {}, 1000);
      ASSERT_TRUE(events);
      for (const Event& event : *events) {
        EXPECT_GT(event.seq, tail);
        tail = event.seq;
        ++seen;
      }
    }
  });
  for (std::thread& writer : writers) writer.join();
  is_over = true;
  reader.join();
  EXPECT_EQ(seen, std::size_t{3} * kEach);
}

TEST_F(PostgresTest, NumbersOfEventsGoOnFarBehindThoseThatACrashMayHaveTaken) {
  JobQueue queue(*db_);
  ASSERT_TRUE(queue.Add(NewFlight(), "{}", Now()));
  const std::int64_t before = *EventLog(*db_).Latest();
  EXPECT_LT(before, 100);
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE catalogue_version SET server_start=now()-interval '1 day'"));
  const auto again = Open();
  const auto and_again = Open();
  ASSERT_TRUE(JobQueue(*and_again).Add(NewFlight(), "{}", Now()));
  EXPECT_GT(*EventLog(*db_).Latest(), before + 4'000);
  EXPECT_LT(*EventLog(*db_).Latest(), before + 9'000);  // once for a start
}

TEST_F(PostgresTest, ARestartOfOneServerLeavesTheJobsOfAnothersWorkers) {
  const auto other = Open("other");
  JobQueue mine(*db_), theirs(*other);
  ASSERT_TRUE(mine.Add(NewFlight(), "{}", Now()));
  ASSERT_TRUE(mine.Add(NewFlight(), "{}", Now()));
  const auto a = *mine.Claim(mine.served_prefix() + "7-0-1", Now());
  const auto b = *theirs.Claim(theirs.served_prefix() + "7-0-1", Now());
  ASSERT_TRUE(a && b);
  EXPECT_EQ(*mine.TakeUpAfterRestart(Now()), 1);
  EXPECT_EQ(*mine.LeaseStateOf(*a), LeaseState::kLost);
  EXPECT_EQ(*theirs.Renew(*b, Now()), LeaseState::kHeld);
}

TEST_F(PostgresTest, WhoMovesThePhotosHasTheCatalogueAlone) {
  auto other = Open("other");
  EXPECT_EQ(db_->HoldAlone().error().code, ErrorCode::kConflict);
  EXPECT_TRUE(Catalogue(*other).AddFlight("f", "{}", Now()));
  other.reset();
  ASSERT_TRUE(db_->HoldAlone());
  EXPECT_EQ(OpenTestCatalogue(path(), 2, "other").error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(Catalogue(*db_).AddFlight("f", "{}", Now()));
  db_.reset();
  EXPECT_TRUE(OpenTestCatalogue(path(), 2, "other"));
}

TEST_F(PostgresTest, AWorkerThatDiesWhileItsMachineGoesOnHasHadItsAttempt) {
  JobQueue queue(*db_);
  ASSERT_TRUE(queue.Add(NewFlight(), "{}", Now()));
  ASSERT_TRUE(queue.Claim("worker-elsewhere-7", Now())->has_value());
  // Another machine, which still runs.
  ASSERT_TRUE(
      db_->Lock()->Exec("INSERT INTO machine VALUES('elsewhere','its boot',now_us());"
                        "UPDATE job SET claimed_in='its boot'"));
  const Time later = Now() + kLeaseTime + seconds(1);
  EXPECT_EQ((*queue.Claim("w", later))->attempt, 2);
  // And one that has started again since.
  ASSERT_TRUE(
      db_->Lock()->Exec("UPDATE job SET claimed_in='its boot';"
                        "UPDATE machine SET boot_id='its next boot' WHERE host='elsewhere'"));
  EXPECT_EQ((*queue.Claim("w", later + kLeaseTime + seconds(1)))->attempt, 2);
}

TEST_F(PostgresTest, AMachineWhoseClockIsWrongAgreesOnTheTime) {
  const auto db = Connection();
  Time shown = Now() - hours(7);
  ServerClock wrong([&] { return shown; });
  EXPECT_LT(std::chrono::abs(wrong.At(shown, *db) - Now()), seconds(20));
  shown = Now() + hours(100);  // it is set: noticed at once
  EXPECT_LT(std::chrono::abs(wrong.At(shown, *db) - Now()), seconds(20));
  ServerClock right;
  const Time now = Now();
  EXPECT_EQ(right.At(now, *db), now);
}

TEST_F(PostgresTest, AFrozenServerDoesNotMoveTheTime) {
  const auto db = Connection();
  const Time start = Now();
  int asked = 0;
  ServerClock clock([&] { return start + seconds(25 * asked++); });  // each answer takes 25 s
  EXPECT_EQ(clock.At(start, *db), start);
  EXPECT_EQ(clock.At(start + seconds(100), *db), start + seconds(100));
}

TEST_F(PostgresTest, ALeaseThatRanOutWhileTheServerWasSilentIsNotTaken) {
  const std::string flight = NewFlight();
  JobQueue queue(*db_);
  ASSERT_TRUE(queue.Add(flight, "{}", Now()));
  ASSERT_TRUE(*queue.Claim("w", Now()));
  const auto other = Open("other");
  JobQueue others(*other);
  const Time later = Now() + kLeaseTime + seconds(1);
  ASSERT_TRUE(db_->Lock()->Exec("SELECT pg_sleep(2.1)"));
  EXPECT_FALSE(*queue.Claim("v", later));
  const auto taken = others.Claim("u", later);  // heard no silence
  ASSERT_TRUE(*taken);
  EXPECT_EQ((*taken)->attempt, 2);
}

TEST(SilenceTest, LongAnswersAreSilenceForAWhile) {
  const Silence::Clock::time_point start(std::chrono::hours(1));
  Silence silence;
  EXPECT_FALSE(silence.EndedWithin(seconds(1'000'000), start));
  silence.Answered(start, start + seconds(1));
  EXPECT_FALSE(silence.EndedWithin(seconds(1'000'000), start + seconds(1)));
  silence.Answered(start, start + seconds(25));
  EXPECT_TRUE(silence.EndedWithin(seconds(7), start + seconds(31)));
  EXPECT_FALSE(silence.EndedWithin(seconds(7), start + seconds(33)));
}

TEST_F(PostgresTest, AgesGoByTheServersClockButNoFurtherThanAnHourAtOnce) {
  const Time before = db_->ages().Now();
  EXPECT_LT(std::chrono::abs(before - Now()), seconds(60));
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE age_clock SET seen_us=seen_us-400*86400000000"));
  ASSERT_TRUE(db_->SaveAges());
  EXPECT_GT(db_->ages().Now(), before + std::chrono::minutes(59));
  EXPECT_LT(db_->ages().Now(), before + std::chrono::minutes(62));
  EXPECT_LT(Open()->ages().Now(), before + std::chrono::minutes(62));
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE age_clock SET seen_us=seen_us+400*86400000000"));
  ASSERT_TRUE(db_->SaveAges());
  EXPECT_GT(db_->ages().Now(), before + std::chrono::minutes(59));
}

TEST_F(PostgresTest, AJobBeginsOnlyAfterWhoChangesItsFilesIsDone) {
  const std::string flight = NewFlight();
  Catalogue catalogue(*db_);
  ASSERT_TRUE(catalogue.AddFile(flight, {"a.jpg", NewId(), 1}, Now()));
  JobQueue queue(*db_);
  ASSERT_TRUE(queue.Add(flight, "{}", Now()));
  const auto other = Open("other");
  {
    const auto db = other->Lock();
    auto transaction = Transaction::Begin(*db, flight);
    auto look = *db->Prepare(std::string("SELECT state FROM job WHERE flight_id=?") + db->ForShare());
    ASSERT_TRUE(*look.Bind(1, flight).Step());
    EXPECT_FALSE(queue.Claim("w", Now())->has_value());
  }
  EXPECT_TRUE(queue.Claim("w", Now())->has_value());
}

TEST_F(PostgresTest, AMessageIsOneServersToSend) {
  Webhooks mine(*db_);
  const auto other = Open("other");
  Webhooks theirs(*other);
  ASSERT_TRUE(mine.Add("https://receiver.example.org/", "secret", Now()));
  JobQueue queue(*db_);
  ASSERT_TRUE(queue.Cancel(queue.Add(NewFlight(), "{}", Now())->id, Now()));
  const Time now = db_->ages().Now();
  const auto due = *mine.Due(now, 10);
  ASSERT_EQ(due.size(), 1u);
  EXPECT_NE(due[0].body.find("\"job\":{\"state\":\"dismissed\""), std::string::npos) << due[0].body;
  EXPECT_TRUE(*mine.Take(due[0], now));
  EXPECT_FALSE(*theirs.Take(due[0], now));
  EXPECT_TRUE(theirs.Due(now, 10)->empty());
  // Unless the one who took it is gone.
  EXPECT_TRUE(*theirs.Take(due[0], now + kDeliveryTurn + seconds(1)));
  ASSERT_TRUE(mine.Heard(due[0]));
  EXPECT_FALSE(*theirs.Take(due[0], now + hours(1)));
}

// Everything that is done to flights and jobs, by many servers at once, on few flights: nobody is told to try
// again, and what is left agrees with itself.
TEST_F(PostgresTest, ManyServersDoEverythingAtOnceAndNobodyHasToTryAgain) {
  constexpr int kServers = 6;
  constexpr int kEnough = 5;
  constexpr int kSteps = 150;
  std::mutex mutex;
  std::vector<std::string> flights;
  for (int i = 0; i < 4; ++i) flights.push_back(NewFlight());
  std::atomic<int> published = 0;
  std::vector<std::thread> servers;
  for (int s = 0; s < kServers; ++s) {
    servers.emplace_back([&, s] {
      const auto own = Open("node" + std::to_string(s));
      Catalogue catalogue(*own);
      JobQueue queue(*own);
      Trash trash(*own);
      Previews previews(*own);
      std::mt19937 random(static_cast<unsigned>(s));
      const auto expect_fine = [&](const auto& outcome, const char* what) {
        if (outcome) return;
        const ErrorCode code = outcome.error().code;
        EXPECT_TRUE(code == ErrorCode::kNotFound || code == ErrorCode::kConflict)
            << what << ": " << outcome.error().detail;
      };
      // How often a job comes as far as its map is chance: enough of them do.
      for (int step = 0; step < kSteps || (published <= kEnough && step < 50 * kSteps); ++step) {
        std::string flight;
        {
          const std::lock_guard lock(mutex);
          flight = flights[random() % flights.size()];
        }
        const std::string name = std::to_string(random() % 3) + ".jpg";
        switch (random() % 9) {
          case 0:
            expect_fine(catalogue.AddFile(flight, {name, NewId(), 1}, Now()), "add");
            break;
          case 1:
            expect_fine(catalogue.AddFileUnderFreeName(flight, {name, NewId(), 1}, Now()),
                        "add under free name");
            break;
          case 2:
            expect_fine(catalogue.RemoveFile(flight, name), "remove");
            break;
          case 3:
            expect_fine(queue.Add(flight, "{}", Now()), "queue");
            break;
          case 4: {
            const auto lease = queue.Claim(own->served_prefix() + std::to_string(step), Now());
            expect_fine(lease, "claim");
            if (!lease || !*lease) break;
            expect_fine(queue.Renew(**lease, Now()), "renew");
            const auto number = queue.ReserveRevision(**lease);
            expect_fine(number, "reserve");
            if (!number || !*number) break;
            Revision revision;
            revision.revision = **number;
            const auto shown = queue.Publish(**lease, revision, Now());
            expect_fine(shown, "publish");
            if (shown && *shown) ++published;
            break;
          }
          case 5:
            expect_fine(trash.Put(flight, Now()), "trash");
            expect_fine(trash.Restore(flight), "restore");
            break;
          case 6:
            expect_fine(previews.Claim(2), "preview");
            break;
          case 7: {
            const auto job = queue.LatestOf(flight);
            if (job && *job) expect_fine(queue.Cancel((*job)->id, Now()), "cancel");
            break;
          }
          default: {
            if (random() % 4 != 0) break;
            expect_fine(catalogue.DeleteFlight(flight), "delete");
            const auto fresh = catalogue.AddFlight("f", "{}", Now());
            ASSERT_TRUE(fresh);
            const std::lock_guard lock(mutex);
            std::replace(flights.begin(), flights.end(), flight, fresh->id);
          }
        }
      }
    });
  }
  for (std::thread& server : servers) server.join();
  EXPECT_GT(published, kEnough);
  // One unfinished job a flight at most, one name once, the shown map among the maps.
  EXPECT_EQ(
      Number(
          "SELECT count(*) FROM (SELECT 1 FROM job WHERE state IN ('accepted','running') GROUP BY flight_id"
          " HAVING count(*)>1) x"),
      0);
  EXPECT_EQ(
      Number(
          "SELECT count(*) FROM flight f WHERE active_revision IS NOT NULL AND NOT EXISTS(SELECT 1 FROM revision r"
          " WHERE r.flight_id=f.id AND r.revision=f.active_revision)"),
      0);
  EXPECT_EQ(
      Number("SELECT count(*) FROM job j WHERE state='accepted' AND NOT EXISTS(SELECT 1 FROM turn t WHERE"
             " t.owner=j.owner AND t.priority=j.priority AND t.first_id<=j.id)"),
      0);
}

TEST_F(PostgresTest, SleepingWorkersHearOfAJob) {
  db_->WaitForJobs();  // listens from here on
  const auto begin = std::chrono::steady_clock::now();
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const auto own = Open();
    ASSERT_TRUE(JobQueue(*own).Add(Catalogue(*own).AddFlight("f", "{}", Now())->id, "{}", Now()));
  });
  db_->WaitForJobs();
  const auto waited = std::chrono::steady_clock::now() - begin;
  later.join();
  EXPECT_GT(waited, std::chrono::milliseconds(250));
  EXPECT_LT(waited, std::chrono::milliseconds(1'900));
}

}  // namespace
}  // namespace skyquilt::storage
