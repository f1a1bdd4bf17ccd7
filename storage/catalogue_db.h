// CatalogueDb: the one database of a data folder (catalogue.db: flights, files, revisions, jobs), opened,
// migrated to the newest schema, and shared by Catalogue and JobQueue. Survives kill -9 and power loss (WAL,
// synchronous FULL). Any thread and any number of processes: within a process users take Lock() for the time
// of a call.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>

#include "core/base/result.h"
#include "storage/sqlite_db.h"

namespace skyquilt::storage {

class CatalogueDb {
 public:
  static Result<std::unique_ptr<CatalogueDb>> Open(const std::filesystem::path& path);

  // The connection, for as long as the lock is held.
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

 private:
  explicit CatalogueDb(SqliteDb db) : db_(std::move(db)) {}
  std::mutex mutex_;
  SqliteDb db_;
};

}  // namespace skyquilt::storage
