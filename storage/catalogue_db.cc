#include "storage/catalogue_db.h"

#include "storage/migrations.h"

namespace skyquilt::storage {

Result<std::unique_ptr<CatalogueDb>> CatalogueDb::Open(const std::filesystem::path& path, int readers) {
  SpaceReserve reserve(path);
  if (reserve.IsNeeded()) {
    reserve.Release();
  } else {
    reserve.Fill();
  }
  Result<SqliteDb> db = SqliteDb::Open(path, OpenMode::kReadWriteCreate);
  if (!db) return db.error();
  const Result<void> tuned = db->Exec("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;");
  if (!tuned) return tuned.error();
  const Result<void> migrated = Migrate(*db);
  if (!migrated) return migrated.error();
  const Result<AgeClock> ages = AgeClock::Open(*db);
  if (!ages) return ages.error();
  std::unique_ptr<CatalogueDb> catalogue(new CatalogueDb(std::move(*db), *ages, std::move(reserve)));
  for (int i = 0; i < readers; ++i) {
    Result<SqliteDb> reader = SqliteDb::Open(path, OpenMode::kReadShared);
    if (!reader) return reader.error();
    catalogue->idle_readers_.push_back(std::make_unique<SqliteDb>(std::move(*reader)));
  }
  return catalogue;
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
