// CatalogueDb: the database of flights, files, revisions and jobs, opened, given its tables where it is new,
// and shared by Catalogue and JobQueue: the one of a data folder (catalogue.db), or one in PostgreSQL that
// many machines share. Survives kill -9 and power loss (WAL, synchronous FULL). Any thread and any number of
// processes: within a process users take Lock() for the time of a call that writes, and Read() for one that
// only reads. Readers wait for no writer, in this process or another: each sees what was committed when its
// statement began. The file and what SQLite keeps beside it are readable by their owner alone. A server of
// PostgreSQL that restarts is kUnavailable for a moment; then all goes on
// (storage/db/postgres/postgres_db.h).
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/base/process/folder_events.h"
#include "core/base/result.h"
#include "storage/db/age_clock.h"
#include "storage/db/outage/silence.h"
#include "storage/db/postgres/catalogue_place.h"
#include "storage/db/postgres/server_clock.h"
#include "storage/db/space_reserve.h"
#include "storage/db/sql_connection.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

// A lease that nobody renews ends after this.
inline constexpr std::chrono::seconds kLeaseTime{15};

// The names of workers that servers supervise begin so; those of one server with its served_prefix().
inline constexpr const char* kServedWorkerPrefix = "serve-";

class CatalogueDb {
 public:
  // Makes the file where it is missing. `readers`: how many may read at the same time; the next one waits for
  // one of them.
  static Result<std::unique_ptr<CatalogueDb>> Open(const std::filesystem::path& path, int readers = 2);
  // Never makes one. Errors: kNotFound (no file, an empty one, or one that is no catalogue of ours),
  // kCorrupt, kIo (also where this user may not read and write it).
  static Result<std::unique_ptr<CatalogueDb>> OpenExisting(const std::filesystem::path& path,
                                                           int readers = 2);
  // In PostgreSQL. `node`: this server among those of the catalogue, the same after a restart; part of the
  // names of its workers. Errors: kNotFound (`may_make` is false and there is none), kConflict (another
  // version), kForbidden, kUnavailable.
  static Result<std::unique_ptr<CatalogueDb>> OpenPostgres(const CataloguePlace& place,
                                                           const std::string& node, bool may_make,
                                                           int readers = 2);

  // The connection that writes, for as long as the lock is held.
  class Access {
   public:
    explicit Access(CatalogueDb& owner) : lock_(owner.mutex_), db_(*owner.db_) {}
    SqlConnection* operator->() const { return &db_; }
    SqlConnection& operator*() const { return db_; }

   private:
    std::lock_guard<std::mutex> lock_;
    SqlConnection& db_;
  };
  Access Lock() { return Access(*this); }

  struct Returner {
    CatalogueDb& owner;
    void operator()(SqlConnection* db) const { owner.GiveBack(std::unique_ptr<SqlConnection>(db)); }
  };
  // A connection that only reads, for as long as this lives. Not while the same thread holds another.
  using ReadAccess = std::unique_ptr<SqlConnection, Returner>;
  ReadAccess Read() { return ReadAccess(TakeReader().release(), Returner{*this}); }

  // For a change that frees space: where it finds the disk full, it gets the reserve and is tried again.
  // `change` takes the lock itself.
  template <typename Change>
  auto Free(Change change) {
    auto outcome = change();
    if (outcome || outcome.error().code != ErrorCode::kOutOfSpace || !reserve_ || !reserve_->Release())
      return outcome;
    return change();
  }
  // For a change that reads and writes rows which others change as well: where PostgreSQL undid it because
  // two waited for each other, it is done again. `change` takes the lock itself.
  template <typename Change>
  auto Again(Change change) {
    constexpr int kTries = 10;
    for (int tries = 1;; ++tries) {
      auto outcome = change();
      if (outcome || tries == kTries || !Lock()->WasUndoneByOthers()) return outcome;
    }
  }
  // Hours of work must not end with a restart of the database: a change that may be said twice is, for a
  // minute, where the catalogue is shared.
  template <typename Change>
  auto Patiently(Change change) {
    constexpr std::chrono::minutes kPatience{1};
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (true) {
      auto outcome = change();
      const bool may_pass = !outcome && outcome.error().code == ErrorCode::kUnavailable;
      if (!IsShared() || !may_pass || std::chrono::steady_clock::now() > end) return outcome;
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
  }
  // The reserve is whole again, if there is room.
  void FillReserve() const {
    if (reserve_) reserve_->Fill();
  }

  // By which things grow old.
  const AgeClock& ages() const { return ages_; }
  Result<void> SaveAges() { return ages_.Save(*Lock()); }

  // For processes that have nothing better to do: how long a call waits for a database that cannot be
  // reached.
  void SetPatience(std::chrono::milliseconds time);
  bool IsShared() const { return place_.has_value(); }
  // No other process, on any machine, uses the catalogue from now on: kConflict where one does, and who comes
  // waits or is refused (kUnavailable). That of a data folder has the folder's lock for this.
  Result<void> HoldAlone();
  // By which leases end: `now` by this machine's clock, as the database's shows it. In a data folder the two
  // are the same.
  Time SharedTime(Time now, SqlConnection& db) { return place_ ? clock_.At(now, db) : now; }
  // Leases that ended before this are lost, at `now` by that clock: none, for half a lease after the database
  // was silent.
  Time LostBefore(Time now) const { return silence_->EndedWithin(kLeaseTime / 2) ? Time() : now; }
  // Prefix of the names of workers that this server supervises: it releases what they held when they die.
  const std::string& served_prefix() const { return served_prefix_; }
  // Until there may be a job to claim, a signal, or the end of two seconds: with PostgreSQL by LISTEN, over a
  // connection of its own; in a data folder WaitForWrites. False: nothing was heard.
  bool WaitForJobs();
  // Until something was written, by any process, a signal, or the end of two seconds: where nothing wakes
  // (PostgreSQL, folders of other machines), a moment. False: nothing was. What is written meanwhile may be
  // missed, rarely. One thread, that of WasWritten.
  bool WaitForWrites();
  // Whether anything was written, by any process, since the same thread last asked; true where that is not
  // known: at first, with PostgreSQL, after an error. It takes a few microseconds. One thread.
  bool WasWritten();

 private:
  CatalogueDb(std::unique_ptr<SqlConnection> db, const AgeClock& ages) : db_(std::move(db)), ages_(ages) {}
  static Result<std::unique_ptr<CatalogueDb>> Prepare(SqliteDb db, const std::filesystem::path& path,
                                                      int readers);
  std::unique_ptr<SqlConnection> TakeReader();
  void GiveBack(std::unique_ptr<SqlConnection> reader);

  std::mutex mutex_;
  std::unique_ptr<SqlConnection> db_;
  std::mutex readers_mutex_;
  std::condition_variable reader_is_back_;
  std::vector<std::unique_ptr<SqlConnection>> idle_readers_;
  AgeClock ages_;
  std::optional<SpaceReserve> reserve_;  // of a data folder
  std::optional<CataloguePlace> place_;  // in PostgreSQL
  ServerClock clock_;
  std::shared_ptr<Silence> silence_ = std::make_shared<Silence>();  // of PostgreSQL
  std::string served_prefix_ = kServedWorkerPrefix;
  std::filesystem::path path_;  // of a data folder's
  std::optional<FolderEvents> events_;
  std::chrono::steady_clock::time_point settled_;  // what was seen to be written is to be read by then
  std::unique_ptr<SqlConnection> listener_;
  std::optional<std::int64_t> seen_version_;  // by the listener, in a data folder
};

}  // namespace skyquilt::storage
