// WorkerPool: the worker processes of a server, and one that draws previews: started from this binary,
// restarted when they end, stopped with the server. The jobs of a dead worker return to the queue at once,
// and its work folder is removed. Used by the main thread only: the kernel ends workers when the thread that
// started them ends.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <vector>

#include "storage/files/data_dir.h"
#include "storage/jobs/job_queue.h"
#include "storage/jobs/unit_queue.h"

namespace skyquilt::server {

class WorkerPool {
 public:
  // `words`: options that every worker is started with.
  WorkerPool(storage::DataDir dir, int count, bool draws_previews, storage::JobQueue& queue,
             storage::UnitQueue& units, std::vector<std::string> words = {});

  // Starts what should run and does not; one that died young waits a little. Called at the start, and now and
  // then.
  void StartMissing();
  // SIGTERM to all that run: they give their jobs back. They are started again by StartMissing.
  void Interrupt();
  // Collects the ended. Called on SIGCHLD.
  void Reap();
  // SIGTERM to all, then SIGKILL to who is left after `grace`.
  void Stop(std::chrono::milliseconds grace);

 private:
  using Clock = std::chrono::steady_clock;
  struct Slot {
    pid_t pid = 0;  // 0: none runs
    bool draws_previews = false;
    std::string name;
    Clock::time_point started;
    Clock::time_point not_before;
  };
  void Start(Slot& slot, int index);
  void Ended(Slot& slot, int wait_status);

  storage::DataDir dir_;
  const std::vector<std::string> words_;
  storage::JobQueue& queue_;
  storage::UnitQueue& units_;
  std::vector<Slot> slots_;
  int starts_ = 0;
  bool is_stopping_ = false;
};

}  // namespace skyquilt::server
