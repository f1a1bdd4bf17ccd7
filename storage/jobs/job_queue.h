// JobQueue: stitching jobs, handed to workers by lease, by priority and then in turn to their owners. A
// worker claims a job, renews its lease by heartbeat, and ends it; each write carries the lease's token, so
// that a worker that slept past its lease can change nothing (fencing). A job whose worker died is handed out
// again, three times at most; one whose worker was cut off by a restart of the server or the machine loses no
// attempt by it, but ten of those end it too. Survives kill -9 of anyone. Any thread, any number of
// processes, and in PostgreSQL any number of machines. Time is given by the caller, by its machine's clock;
// what is stored and compared is the database's (CatalogueDb::SharedTime). Errors: kNotFound, kConflict (the
// flight has an unfinished job; the job is finished), kOutOfSpace, kUnavailable.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "storage/catalogue/catalogue.h"
#include "storage/catalogue/stage_costs.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"
#include "storage/jobs/map_products.h"

namespace skyquilt::storage {

inline constexpr int kMaxAttempts = 3;
// Troubles of machines (disk, network, store) that cost a job or a unit no attempt: more than many machines
// have by chance with one piece of work. From then on it brings them along, and ends by its attempts.
inline constexpr int kFreeTroubles = 10;
// By restarts. More than a machine sees by chance while it works on one job.
inline constexpr int kMaxInterruptions = 10;

enum class JobState { kAccepted, kRunning, kSuccessful, kFailed, kDismissed };
const char* JobStateName(JobState state);

struct JobError {
  std::string code;  // an ErrorCodeName
  std::string message;
  std::string reason = {};  // the same as a remark (core/flight/remarks/remark_json.h); empty: none does
};

// Where in the queue a job comes. Higher priorities first; among equals whoever is served least at the
// moment.
struct JobTurn {
  int priority = 0;
  std::string owner;  // id of a token; empty where nobody showed one
};
inline constexpr int kMaxPriority = 10;

struct Job {
  std::string id;
  std::string flight_id;
  std::string options;  // JSON text
  JobState state = JobState::kAccepted;
  std::string stage;
  double progress = 0.0;  // 0..1 over the whole job
  std::string message;
  int priority = 0;
  std::optional<Expectation> expected = {};  // without shares; once it runs and others have been measured
  int attempts = 0;
  bool cancel_requested = false;
  std::optional<JobError> error;
  Time created;
  std::optional<Time> started;
  std::optional<Time> attempt_started;
  std::optional<Time> finished;
};

// The right to run one job until the lease ends.
struct Lease {
  std::string job_id;
  std::string flight_id;
  std::string options;
  std::int64_t token = 0;
  int attempt = 1;
};

// How a worker ended: by itself, while its server went on living; or with its server or the machine.
enum class WorkerEnd { kDied, kInterrupted };

enum class LeaseState { kHeld, kCancelRequested, kLost };

struct JobProgress {
  std::string stage;
  double fraction = 0.0;
  std::string message;
};

// How many jobs there are of each state.
struct JobCounts {
  int accepted = 0;
  int running = 0;
  int successful = 0;
  int failed = 0;
  int dismissed = 0;
};

class JobQueue {
 public:
  explicit JobQueue(CatalogueDb& db) : db_(db) {}

  Result<Job> Add(const std::string& flight_id, const std::string& options, Time now,
                  const JobTurn& turn = {});
  Result<Job> Get(const std::string& id) const;
  // Newest first; of one flight or of all. Older than `cursor` (the id that an earlier page ended with).
  Result<std::vector<Job>> List(const std::optional<std::string>& flight_id, int limit,
                                const std::optional<std::string>& cursor = std::nullopt) const;
  Result<std::optional<Job>> LatestOf(const std::string& flight_id) const;
  Result<std::vector<Job>> ListRunning() const;
  Result<JobCounts> Count() const;
  // Waiting and running ones, counted no further than `most`: cheap however many there are.
  Result<int> CountUnfinished(int most) const;
  // A waiting job ends at once; a running one when its worker notices. Cancelling twice changes nothing.
  Result<Job> Cancel(const std::string& id, Time now);
  // Forgets a job that has ended. kConflict: it has not.
  Result<void> Remove(const std::string& id);

  // For workers.
  Result<std::optional<Lease>> Claim(std::string_view worker, Time now);
  Result<LeaseState> Renew(const Lease& lease, Time now);
  Result<LeaseState> LeaseStateOf(const Lease& lease) const;  // like Renew, but only reads
  // How long the whole of it should take.
  Result<LeaseState> Expect(const Lease& lease, const Expectation& expectation);
  Result<LeaseState> ReportProgress(const Lease& lease, const JobProgress& progress);
  // The job ended badly. With `may_retry` it waits for another attempt if any is left; one that someone
  // wished to cancel is dismissed, whatever ended it. False: the lease was lost.
  Result<bool> Fail(const Lease& lease, const Error& error, bool may_retry, Time now);
  // The worker saw the wish to cancel and stopped. False: the lease was lost.
  Result<bool> Dismiss(const Lease& lease, Time now);
  // The worker must stop, or its machine is in trouble, through no fault of the job's: the attempt does not
  // count. False: the lease was lost.
  Result<bool> GiveBack(const Lease& lease, Time now);
  // The machine that has it is in trouble, once more; answers how often that was, whatever machine it was.
  // 0: the lease was lost.
  Result<int> CountTrouble(const Lease& lease);

  // Publishing, in two steps around the move of the files. Absent or false: the lease was lost. False as well
  // where somebody wished to cancel: what was cancelled is not shown (Dismiss).
  Result<std::optional<std::int64_t>> ReserveRevision(const Lease& lease);
  // Where the catalogue is shared, tries for a minute while its database cannot be reached; said again after
  // an answer that was lost, it answers what the first one did. `products`: of a map that was put into a
  // store.
  Result<bool> Publish(const Lease& lease, const Revision& revision, Time now,
                       const std::vector<MapProduct>& products = {});

  // A worker process ended: what it held waits for its next attempt now rather than at the lease's end.
  // Answers how many jobs it held.
  Result<int> ReleaseWorker(const std::string& worker, WorkerEnd end, Time now);
  // A server starts: what workers of earlier servers held was interrupted; where servers share the catalogue,
  // what those of this one held. Answers how many jobs.
  Result<int> TakeUpAfterRestart(Time now);
  // What the names of this server's workers begin with.
  const std::string& served_prefix() const { return db_.served_prefix(); }
  // Until there may be a job to claim, or for two seconds (false).
  bool WaitForJobs() { return db_.WaitForJobs(); }
  // Flights that a live lease may be publishing into, with the lease as "<job>-<token>".
  struct LiveLease {
    std::string flight_id;
    std::string work_name;
  };
  Result<std::vector<LiveLease>> LiveLeases(Time now) const;
  // Jobs that wait or run: what an attempt of theirs left is of use to the next.
  Result<std::vector<std::string>> UnfinishedJobs() const;
  // Also where its flight is in the trash, as the next. Of a job that is not known: no.
  Result<bool> HasEnded(const std::string& id) const;
  Result<std::vector<std::string>> JobsOf(const std::string& flight_id) const;
  // Jobs under whose ids units lie that are of use: to jobs that wait or run, or to one that takes them over.
  Result<std::vector<std::string>> UnitsOfUse(Time now) const;

 private:
  CatalogueDb& db_;
};

// The name of a lease's own folder below work/: no two leases ever share one.
std::string WorkName(const Lease& lease);
// The job whose folder this is; empty for a folder of another kind.
std::string JobOfWorkName(const std::string& work_name);

}  // namespace skyquilt::storage
