// CatalogueDb: the one database of a data folder (catalogue.db: flights, files, revisions, jobs), opened,
// given its tables where it is new, and shared by Catalogue and JobQueue. Survives kill -9 and power loss
// (WAL, synchronous FULL). Any thread and any number of processes: within a process users take Lock() for the
// time of a call that writes, and Read() for one that only reads. Readers wait for no writer, in this process
// or another: each sees what was committed when its statement began. The file and what SQLite keeps beside it
// are readable by their owner alone.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/result.h"
#include "storage/db/age_clock.h"
#include "storage/db/space_reserve.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

class CatalogueDb {
 public:
  // Makes the file where it is missing. `readers`: how many may read at the same time; the next one waits for
  // one of them.
  static Result<std::unique_ptr<CatalogueDb>> Open(const std::filesystem::path& path, int readers = 2);
  // Never makes one. Errors: kNotFound (no file, an empty one, or one that is no catalogue of ours),
  // kCorrupt.
  static Result<std::unique_ptr<CatalogueDb>> OpenExisting(const std::filesystem::path& path,
                                                           int readers = 2);

  // The connection that writes, for as long as the lock is held.
  class Access {
   public:
    explicit Access(CatalogueDb& owner) : lock_(owner.mutex_), db_(owner.db_) {}
    SqliteDb* operator->() const { return &db_; }
    SqliteDb& operator*() const { return db_; }

   private:
    std::lock_guard<std::mutex> lock_;
    SqliteDb& db_;
  };
  Access Lock() { return Access(*this); }

  // A connection that only reads, for as long as this lives. Not while the same thread holds another.
  class ReadAccess {
   public:
    explicit ReadAccess(CatalogueDb& owner) : owner_(owner), db_(owner.TakeReader()) {}
    ~ReadAccess() { owner_.GiveBack(std::move(db_)); }
    ReadAccess(const ReadAccess&) = delete;
    ReadAccess& operator=(const ReadAccess&) = delete;
    SqliteDb* operator->() const { return db_.get(); }
    SqliteDb& operator*() const { return *db_; }

   private:
    CatalogueDb& owner_;
    std::unique_ptr<SqliteDb> db_;
  };
  ReadAccess Read() { return ReadAccess(*this); }

  // For a change that frees space: where it finds the disk full, it gets the reserve and is tried again.
  // `change` takes the lock itself.
  template <typename Change>
  auto Free(Change change) {
    auto outcome = change();
    if (outcome || outcome.error().code != ErrorCode::kOutOfSpace || !reserve_.Release()) return outcome;
    return change();
  }
  // The reserve is whole again, if there is room.
  void FillReserve() const { reserve_.Fill(); }

  // By which things grow old.
  const AgeClock& ages() const { return ages_; }
  Result<void> SaveAges() { return ages_.Save(*Lock()); }

 private:
  CatalogueDb(SqliteDb db, AgeClock ages, SpaceReserve reserve)
      : db_(std::move(db)), ages_(ages), reserve_(std::move(reserve)) {}
  static Result<std::unique_ptr<CatalogueDb>> Prepare(SqliteDb db, const std::filesystem::path& path,
                                                      int readers);
  std::unique_ptr<SqliteDb> TakeReader();
  void GiveBack(std::unique_ptr<SqliteDb> reader);

  std::mutex mutex_;
  SqliteDb db_;
  std::mutex readers_mutex_;
  std::condition_variable reader_is_back_;
  std::vector<std::unique_ptr<SqliteDb>> idle_readers_;
  AgeClock ages_;
  SpaceReserve reserve_;
};

}  // namespace skyquilt::storage
