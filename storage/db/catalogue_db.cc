#include "storage/db/catalogue_db.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "storage/db/schema.h"

namespace skyquilt::storage {
namespace {

// Tokens' digests and the secrets of webhooks are in it. SQLite gives what it keeps beside a file the file's
// mode.
void KeepFromOthers(const std::filesystem::path& path) {
  // Never one that exists: closing any descriptor of a file lets go of all locks that this process has on it,
  // also those of SQLite's connections.
  const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (fd >= 0) close(fd);  // where it cannot be made, opening the database says why
  for (const char* ending : {"", "-wal", "-shm"}) {
    // Files of an earlier version were readable by all. Another user's file keeps its mode: then it is that
    // user's care.
    (void)chmod((path.string() + ending).c_str(), 0600);
  }
}

Result<bool> IsCatalogue(SqliteDb& db) {
  Result<Statement> query = db.Prepare(
      "SELECT count(*) FROM sqlite_master WHERE type='table' AND name IN ('flight','file','revision','job')");
  if (!query) return query.error();
  const Result<bool> row = query->Step();
  if (!row) return row.error();
  return query->ColumnInt64(0) == 4;
}

// Room to start with, where the disk is full.
void GiveRoom(const std::filesystem::path& path) {
  const SpaceReserve reserve(path);
  if (reserve.IsNeeded()) reserve.Release();
}

// Room to delete with, where it is not.
void KeepRoom(const std::filesystem::path& path) {
  const SpaceReserve reserve(path);
  if (!reserve.IsNeeded()) reserve.Fill();
}

}  // namespace

Result<std::unique_ptr<CatalogueDb>> CatalogueDb::Prepare(SqliteDb db, const std::filesystem::path& path,
                                                          int readers) {
  const Result<void> tuned = db.Exec("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;");
  if (!tuned) return tuned.error();
  const Result<void> prepared = PrepareSchema(db);
  if (!prepared) return prepared.error();
  const Result<AgeClock> ages = AgeClock::Open(db);
  if (!ages) return ages.error();
  std::unique_ptr<CatalogueDb> catalogue(new CatalogueDb(std::move(db), *ages, SpaceReserve(path)));
  for (int i = 0; i < readers; ++i) {
    Result<SqliteDb> reader = SqliteDb::Open(path, OpenMode::kReadShared);
    if (!reader) return reader.error();
    catalogue->idle_readers_.push_back(std::make_unique<SqliteDb>(std::move(*reader)));
  }
  return catalogue;
}

Result<std::unique_ptr<CatalogueDb>> CatalogueDb::Open(const std::filesystem::path& path, int readers) {
  GiveRoom(path);
  KeepRoom(path);
  KeepFromOthers(path);
  Result<SqliteDb> db = SqliteDb::Open(path, OpenMode::kReadWriteCreate);
  if (!db) return db.error();
  return Prepare(std::move(*db), path, readers);
}

Result<std::unique_ptr<CatalogueDb>> CatalogueDb::OpenExisting(const std::filesystem::path& path,
                                                               int readers) {
  struct stat status {};
  const Error none{ErrorCode::kNotFound, "There is no catalogue at " + path.string() + ".", ""};
  if (stat(path.c_str(), &status) != 0 || status.st_size == 0) return none;
  if (!S_ISREG(status.st_mode)) return none;
  GiveRoom(path);
  Result<SqliteDb> db = SqliteDb::Open(path, OpenMode::kReadWrite);
  if (!db) return db.error();
  // Before anything is changed in it: it may be another program's.
  const Result<bool> is_ours = IsCatalogue(*db);
  if (!is_ours) return is_ours.error();
  if (!*is_ours) return none;
  KeepRoom(path);
  KeepFromOthers(path);
  return Prepare(std::move(*db), path, readers);
}

std::unique_ptr<SqliteDb> CatalogueDb::TakeReader() {
  std::unique_lock lock(readers_mutex_);
  reader_is_back_.wait(lock, [&] { return !idle_readers_.empty(); });
  std::unique_ptr<SqliteDb> reader = std::move(idle_readers_.back());
  idle_readers_.pop_back();
  return reader;
}

void CatalogueDb::GiveBack(std::unique_ptr<SqliteDb> reader) {
  const std::lock_guard lock(readers_mutex_);
  idle_readers_.push_back(std::move(reader));
  reader_is_back_.notify_one();
}

}  // namespace skyquilt::storage
