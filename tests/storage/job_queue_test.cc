#include "storage/jobs/job_queue.h"

#include <set>
#include <thread>

#include "core/flight/remarks/because.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {
namespace {

using std::chrono::seconds;

class JobQueueTest : public CatalogueFixture {
 protected:
  std::string NewFlight() { return catalogue_.AddFlight("field", "{}", now_)->id; }
  Job NewJob() { return *queue_.Add(NewFlight(), "{}", now_); }
  std::string Served(const std::string& name) const { return queue_.served_prefix() + name; }
  Lease Claimed() { return **queue_.Claim("w", now_); }
  // Workers that die, until nobody takes up the last job.
  void DieAtEveryAttempt() {
    for (int attempt = 1; attempt <= kMaxAttempts; ++attempt) {
      ASSERT_EQ((*queue_.Claim("w", now_))->attempt, attempt);
      now_ += kLeaseTime + seconds(1);
    }
    EXPECT_FALSE(queue_.Claim("w", now_)->has_value());
  }
};

Revision Made(std::int64_t number) {
  Revision revision;
  revision.revision = number;
  revision.bounds = {10, 50, 10.1, 50.1};
  revision.min_zoom = 15;
  revision.max_zoom = 21;
  revision.gsd_m = 0.03;
  revision.photos_total = 6;
  revision.photos_aligned = 4;
  revision.photos_pose_only = 1;
  revision.photos_left_out = 1;
  revision.first_capture = "2015-10-27T09:31:02-04:00";
  revision.last_capture = "2015-10-27T09:40:12-04:00";
  revision.quality = R"({"status":"ready"})";
  return revision;
}

TEST_F(JobQueueTest, HandsAJobToOneWorkerOnly) {
  const Job job = NewJob();
  const auto lease = queue_.Claim("a", now_);
  ASSERT_TRUE(lease && lease->has_value());
  EXPECT_EQ((*lease)->job_id, job.id);
  EXPECT_EQ((*lease)->attempt, 1);
  EXPECT_FALSE(queue_.Claim("b", now_)->has_value());
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kRunning);
}

TEST_F(JobQueueTest, HandsOutTheOldestFirst) {
  const Job first = NewJob();
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  NewJob();
  EXPECT_EQ(Claimed().job_id, first.id);
}

TEST_F(JobQueueTest, RefusesASecondUnfinishedJobOfAFlight) {
  const Job job = NewJob();
  EXPECT_EQ(queue_.Add(job.flight_id, "{}", now_).error().code, ErrorCode::kConflict);
  ASSERT_TRUE(queue_.Cancel(job.id, now_));
  EXPECT_TRUE(queue_.Add(job.flight_id, "{}", now_));
}

TEST_F(JobQueueTest, RefusesAJobOfNoFlight) {
  EXPECT_EQ(queue_.Add("nothing", "{}", now_).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(queue_.Get("nothing").error().code, ErrorCode::kNotFound);
}

TEST_F(JobQueueTest, GivesAnExpiredJobToTheNextAndFencesTheFirst) {
  const Job job = NewJob();
  const Lease old = Claimed();
  const Time later = now_ + kLeaseTime + seconds(1);
  const Lease fresh = **queue_.Claim("b", later);
  EXPECT_EQ(fresh.job_id, job.id);
  EXPECT_GT(fresh.token, old.token);
  EXPECT_EQ(*queue_.Renew(old, later), LeaseState::kLost);
  EXPECT_EQ(*queue_.ReportProgress(old, {"render", 0.9, "late"}), LeaseState::kLost);
  EXPECT_FALSE(queue_.ReserveRevision(old)->has_value());
  EXPECT_FALSE(*queue_.Publish(old, Made(1), later));
  EXPECT_FALSE(*queue_.Fail(old, {ErrorCode::kIo, "x", ""}, true, later));
  EXPECT_FALSE(*queue_.Dismiss(old, later));
  EXPECT_FALSE(*queue_.GiveBack(old, later));
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kRunning);
  EXPECT_EQ(queue_.Get(job.id)->stage, "");
  EXPECT_TRUE(*queue_.Publish(fresh, Made(1), later));
}

TEST_F(JobQueueTest, APublicationThatIsSaidTwiceIsOne) {
  // As after an answer that nobody heard: who takes it for lost removes the map that is shown.
  const Job job = NewJob();
  const Lease lease = Claimed();
  ASSERT_TRUE(*queue_.Publish(lease, Made(1), now_));
  EXPECT_TRUE(*queue_.Publish(lease, Made(1), now_));
  EXPECT_FALSE(*queue_.Publish(lease, Made(2), now_));
  EXPECT_EQ(*catalogue_.Revisions(job.flight_id), (std::vector<std::int64_t>{1}));
  Lease earlier = lease;
  --earlier.token;
  EXPECT_FALSE(*queue_.Publish(earlier, Made(1), now_));
}

TEST_F(JobQueueTest, KeepsALeaseThatIsRenewed) {
  NewJob();
  const Lease lease = Claimed();
  for (int i = 1; i <= 5; ++i) {
    const Time then = now_ + i * (kLeaseTime - seconds(1));
    EXPECT_FALSE(queue_.Claim("b", then)->has_value());
    EXPECT_EQ(*queue_.Renew(lease, then), LeaseState::kHeld);
  }
}

TEST_F(JobQueueTest, GivesUpAfterThreeAttempts) {
  const Job job = NewJob();
  DieAtEveryAttempt();
  const Job ended = *queue_.Get(job.id);
  EXPECT_EQ(ended.state, JobState::kFailed);
  ASSERT_TRUE(ended.error);
  EXPECT_EQ(ended.error->code, "internal");
}

TEST_F(JobQueueTest, RetriesAFailureOfTheMachineLaterButNotOneOfTheInput) {
  const Job job = NewJob();
  ASSERT_TRUE(*queue_.Fail(Claimed(), {ErrorCode::kIo, "disk", ""}, true, now_));
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kAccepted);
  EXPECT_FALSE(queue_.Claim("w", now_)->has_value());
  const auto again = queue_.Claim("w", now_ + seconds(60));
  ASSERT_TRUE(again->has_value());
  ASSERT_TRUE(*queue_.Fail(**again, {ErrorCode::kUnprocessable, "no photos", ""}, false, now_));
  const Job ended = *queue_.Get(job.id);
  EXPECT_EQ(ended.state, JobState::kFailed);
  EXPECT_EQ(ended.error->code, "unprocessable");
  EXPECT_EQ(ended.error->message, "no photos");
  EXPECT_EQ(ended.error->reason, "") << "the message alone tells";
}

TEST_F(JobQueueTest, KeepsWhyAJobFailedAsACode) {
  const Job full = NewJob();
  ASSERT_TRUE(*queue_.Fail(Claimed(), {ErrorCode::kOutOfSpace, "/d: no space", ""}, false, now_));
  EXPECT_EQ(queue_.Get(full.id)->error->reason, R"({"code":"fail_disk_full","values":{}})");
  const Job quick = NewJob();
  const Error few = flight::Because(ErrorCode::kUnprocessable, {flight::RemarkCode::kFailFewPoints,
                                                                {{"points", 4}, {"used", 2}, {"needed", 3}}});
  ASSERT_TRUE(*queue_.Fail(Claimed(), few, false, now_));
  EXPECT_EQ(queue_.Get(quick.id)->error->message, few.message);
  EXPECT_EQ(queue_.Get(quick.id)->error->reason,
            R"({"code":"fail_few_points","values":{"needed":3,"points":4,"used":2}})");
}

TEST_F(JobQueueTest, ShowsTheWishToCancelToTheWorker) {
  const Job job = NewJob();
  const Lease lease = Claimed();
  EXPECT_EQ(*queue_.LeaseStateOf(lease), LeaseState::kHeld);
  EXPECT_EQ(queue_.Cancel(job.id, now_)->state, JobState::kRunning);
  EXPECT_TRUE(queue_.Cancel(job.id, now_));
  EXPECT_EQ(*queue_.LeaseStateOf(lease), LeaseState::kCancelRequested);
  // Also of one who sees it when the map is made.
  EXPECT_FALSE(*queue_.Publish(lease, Made(1), now_));
  EXPECT_TRUE(catalogue_.Revisions(job.flight_id)->empty());
  EXPECT_EQ(*queue_.LeaseStateOf(lease), LeaseState::kCancelRequested);
  EXPECT_TRUE(*queue_.Dismiss(lease, now_));
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kDismissed);
}

TEST_F(JobQueueTest, DismissesAWaitingJobAtOnce) {
  EXPECT_EQ(queue_.Cancel(NewJob().id, now_)->state, JobState::kDismissed);
  EXPECT_FALSE(queue_.Claim("w", now_)->has_value());
}

TEST_F(JobQueueTest, DismissesACancelledJobWhoseWorkerDied) {
  const Job job = NewJob();
  Claimed();
  ASSERT_TRUE(queue_.Cancel(job.id, now_));
  EXPECT_FALSE(queue_.Claim("w", now_ + kLeaseTime + seconds(1))->has_value());
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kDismissed);
}

TEST_F(JobQueueTest, ACancelledJobThatFailsOnTheWayIsDismissed) {
  const Job job = NewJob();
  const Lease lease = Claimed();
  ASSERT_TRUE(queue_.Cancel(job.id, now_));
  ASSERT_TRUE(*queue_.Fail(lease, {ErrorCode::kNotFound, "its flight is in the trash", ""}, true, now_));
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kDismissed);
  EXPECT_FALSE(queue_.Get(job.id)->error);
}

TEST_F(JobQueueTest, PublishesWhenThePhotosWereTaken) {
  const Job job = NewJob();
  ASSERT_TRUE(*queue_.Publish(Claimed(), Made(1), now_));
  const auto shown = *catalogue_.ActiveRevision(job.flight_id);
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->first_capture, "2015-10-27T09:31:02-04:00");
  EXPECT_EQ(shown->last_capture, "2015-10-27T09:40:12-04:00");
  EXPECT_EQ(shown->quality, R"({"status":"ready"})");
}

TEST_F(JobQueueTest, RefusesToCancelWhatIsFinished) {
  const Job job = NewJob();
  ASSERT_TRUE(*queue_.Publish(Claimed(), Made(1), now_));
  EXPECT_EQ(queue_.Cancel(job.id, now_).error().code, ErrorCode::kConflict);
}

TEST_F(JobQueueTest, CountsByStateAndTheUnfinishedNoFurtherThanAsked) {
  for (int i = 0; i < 4; ++i) NewJob();
  ASSERT_TRUE(*queue_.Dismiss(Claimed(), now_));
  Claimed();
  const JobCounts counts = *queue_.Count();
  EXPECT_EQ(counts.accepted, 2);
  EXPECT_EQ(counts.running, 1);
  EXPECT_EQ(counts.dismissed, 1);
  EXPECT_EQ(*queue_.CountUnfinished(10), 3);
  EXPECT_EQ(*queue_.CountUnfinished(2), 2);
}

TEST_F(JobQueueTest, DoesNotCountAnAttemptThatWasGivenBack) {
  const Job job = NewJob();
  for (int i = 0; i < 5; ++i) {
    const Lease lease = Claimed();
    EXPECT_EQ(lease.attempt, 1);
    ASSERT_TRUE(*queue_.GiveBack(lease, now_));
  }
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kAccepted);
}

TEST_F(JobQueueTest, ReleasesWhatADeadWorkerHeld) {
  NewJob();
  ASSERT_TRUE(queue_.Claim(Served("1-2"), now_)->has_value());
  EXPECT_EQ(*queue_.ReleaseWorker("other", WorkerEnd::kDied, now_), 0);
  EXPECT_EQ(*queue_.ReleaseWorker(Served("1-2"), WorkerEnd::kDied, now_), 1);
  EXPECT_EQ((*queue_.Claim("w", now_))->attempt, 2);
}

TEST_F(JobQueueTest, ARestartOfTheServerIsNoAttempt) {
  const Job job = NewJob();
  for (int i = 1; i < kMaxInterruptions; ++i) {
    const auto lease = queue_.Claim(Served("1-" + std::to_string(i)), now_);
    ASSERT_TRUE(lease->has_value()) << i;
    EXPECT_EQ((*lease)->attempt, 1);
    EXPECT_EQ(*queue_.TakeUpAfterRestart(now_), 1);
    EXPECT_EQ(*queue_.Renew(**lease, now_), LeaseState::kLost);
  }
  // All its attempts are left.
  DieAtEveryAttempt();
  EXPECT_EQ(queue_.Get(job.id)->error->code, "internal");
}

TEST_F(JobQueueTest, AJobThatEveryRunEndsInARestartEndsWithItsOwnWords) {
  const Job job = NewJob();
  for (int i = 1; i <= kMaxInterruptions; ++i) {
    ASSERT_TRUE(queue_.Claim(Served("1-" + std::to_string(i)), now_)->has_value()) << i;
    ASSERT_TRUE(queue_.TakeUpAfterRestart(now_));
  }
  EXPECT_FALSE(queue_.Claim("w", now_)->has_value());
  const Job ended = *queue_.Get(job.id);
  EXPECT_EQ(ended.state, JobState::kFailed);
  EXPECT_EQ(ended.error->code, "unavailable");
  EXPECT_NE(ended.error->message.find("interrupted 10 times by restarts"), std::string::npos);
  EXPECT_TRUE(ended.finished);
  EXPECT_TRUE(queue_.Add(job.flight_id, "{}", now_));
}

TEST_F(JobQueueTest, AServersWorkerThatItsServerKilledIsNoAttempt) {
  NewJob();
  ASSERT_TRUE(queue_.Claim(Served("1-1"), now_)->has_value());
  EXPECT_EQ(*queue_.ReleaseWorker(Served("1-1"), WorkerEnd::kInterrupted, now_), 1);
  EXPECT_EQ((*queue_.Claim("w", now_))->attempt, 1);
}

TEST_F(JobQueueTest, ALeaseOfAServersWorkerRunsOutOnlyWithItsServer) {
  NewJob();
  ASSERT_TRUE(queue_.Claim(Served("1-1"), now_)->has_value());
  EXPECT_EQ((*queue_.Claim("worker-7", now_ + kLeaseTime + seconds(1)))->attempt, 1);
}

TEST_F(JobQueueTest, ARestartOfTheMachineIsNoAttemptOfAnyWorker) {
  const Job job = NewJob();
  Time then = now_;
  for (int i = 1; i < kMaxInterruptions; ++i) {
    ASSERT_EQ((*queue_.Claim("worker-7", then))->attempt, 1);
    ASSERT_TRUE(db_->Lock()->Exec("UPDATE job SET claimed_in='an earlier start of the machine'"));
    then += kLeaseTime + seconds(1);
  }
  ASSERT_EQ((*queue_.Claim("worker-7", then))->attempt, 1);
  // One that dies while its machine goes on has had its attempt.
  then += kLeaseTime + seconds(1);
  EXPECT_EQ((*queue_.Claim("worker-7", then))->attempt, 2);
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kRunning);
}

TEST_F(JobQueueTest, AWorkerOfOthersThatLivesThroughAServersRestartGoesOn) {
  NewJob();
  const Lease lease = **queue_.Claim("worker-7", now_);
  EXPECT_EQ(*queue_.TakeUpAfterRestart(now_), 0);
  EXPECT_EQ(*queue_.Renew(lease, now_), LeaseState::kHeld);
  // Heard since: its death is its own.
  EXPECT_EQ((*queue_.Claim("w", now_ + kLeaseTime + seconds(1)))->attempt, 2);
}

TEST_F(JobQueueTest, AWorkerOfOthersThatIsNotHeardAfterAServersRestartWasInterrupted) {
  NewJob();
  ASSERT_TRUE(queue_.Claim("worker-7", now_)->has_value());
  EXPECT_EQ(*queue_.TakeUpAfterRestart(now_), 0);
  // Where others share the catalogue, the restart of one server says nothing of other workers.
  EXPECT_EQ((*queue_.Claim("w", now_ + kLeaseTime + seconds(1)))->attempt, TestsPostgres() ? 2 : 1);
}

TEST_F(JobQueueTest, AnInterruptedJobThatSomeoneCancelledIsDismissed) {
  const Job job = NewJob();
  ASSERT_TRUE(queue_.Claim(Served("1-1"), now_)->has_value());
  ASSERT_TRUE(queue_.Cancel(job.id, now_));
  ASSERT_TRUE(queue_.TakeUpAfterRestart(now_));
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kDismissed);
}

TEST_F(JobQueueTest, AClockThatWasAheadHoldsNothingUpAfterARestart) {
  const Time ahead = now_ + std::chrono::days(30);
  const Job leased = NewJob();
  ASSERT_TRUE(queue_.Claim("worker-7", ahead)->has_value());
  const Job paused = NewJob();
  ASSERT_TRUE(*queue_.Fail(**queue_.Claim("worker-8", ahead), {ErrorCode::kIo, "disk", ""}, true, ahead));
  EXPECT_FALSE(queue_.Claim("w", now_)->has_value());
  ASSERT_TRUE(queue_.TakeUpAfterRestart(now_));
  EXPECT_TRUE(queue_.Claim("w", now_)->has_value());
  EXPECT_TRUE(queue_.Claim("w", now_)->has_value());
}

TEST_F(JobQueueTest, PublishesARevisionAndForgetsAllButTheOneBefore) {
  const std::string flight = NewFlight();
  for (int i = 1; i <= 3; ++i) {
    ASSERT_TRUE(queue_.Add(flight, "{}", now_));
    const Lease lease = Claimed();
    ASSERT_EQ(**queue_.ReserveRevision(lease), i);
    ASSERT_TRUE(*queue_.Publish(lease, Made(i), now_));
    EXPECT_EQ((*catalogue_.ActiveRevision(flight))->revision, i);
  }
  EXPECT_EQ(*catalogue_.Revisions(flight), (std::vector<std::int64_t>{2, 3}));
  EXPECT_EQ((*catalogue_.ActiveRevision(flight))->photos_aligned, 4);
}

TEST_F(JobQueueTest, LosesTheLeaseWhenTheFlightIsDeleted) {
  const Job job = NewJob();
  const Lease lease = Claimed();
  ASSERT_TRUE(catalogue_.DeleteFlight(job.flight_id));
  EXPECT_EQ(*queue_.Renew(lease, now_), LeaseState::kLost);
  EXPECT_FALSE(*queue_.Publish(lease, Made(1), now_));
}

TEST(JobQueueConcurrency, GivesEachJobToExactlyOneOfManyConnections) {
  constexpr int kJobs = 40;
  constexpr int kWorkers = 4;
  test::TemporaryFolder dir;
  const auto db = *OpenTestCatalogue(dir.path() / "catalogue.db");
  Catalogue catalogue(*db);
  JobQueue queue(*db);
  for (int i = 0; i < kJobs; ++i) {
    ASSERT_TRUE(queue.Add(catalogue.AddFlight("f", "{}", Now())->id, "{}", Now()));
  }
  std::mutex mutex;
  std::multiset<std::string> claimed;
  std::vector<std::thread> workers;
  for (int w = 0; w < kWorkers; ++w) {
    workers.emplace_back([&, w] {
      // Two of the four share a connection, the others have their own, as processes would.
      const auto own = w < 2 ? nullptr : *OpenTestCatalogue(dir.path() / "catalogue.db");
      JobQueue mine(own != nullptr ? *own : *db);
      while (true) {
        const auto lease = mine.Claim("w" + std::to_string(w), Now());
        ASSERT_TRUE(lease) << lease.error().detail;
        if (!lease->has_value()) return;
        const std::lock_guard lock(mutex);
        claimed.insert((*lease)->job_id);
      }
    });
  }
  for (std::thread& worker : workers) worker.join();
  EXPECT_EQ(claimed.size(), static_cast<std::size_t>(kJobs));
  EXPECT_EQ(std::set<std::string>(claimed.begin(), claimed.end()).size(), static_cast<std::size_t>(kJobs));
}

TEST(JobQueue, ANewJobIsTheLatestAlsoWhereTheClockWasSetBackBeforeAStart) {
  const test::TemporaryFolder dir;
  const auto earlier = OpenTestCatalogue(dir.path() / "catalogue.db");
  const std::string flight = test::ValueOf(Catalogue(**earlier).AddFlight("field", "{}", Now())).id;
  JobQueue before(**earlier);
  ASSERT_TRUE(before.Cancel(test::ValueOf(before.Add(flight, "{}", Now())).id, Now()));
  ASSERT_TRUE((*earlier)->Lock()->Change("UPDATE job SET id='1'||substr(id,2)"));  // centuries ahead
  const auto later = OpenTestCatalogue(dir.path() / "catalogue.db");
  JobQueue queue(**later);
  const Job next = test::ValueOf(queue.Add(flight, "{}", Now()));
  EXPECT_EQ(test::ValueOf(test::ValueOf(queue.LatestOf(flight))).id, next.id);
}

}  // namespace
}  // namespace skyquilt::storage
