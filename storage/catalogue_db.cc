#include "storage/catalogue_db.h"

#include "storage/migrations.h"

namespace skyquilt::storage {

Result<std::unique_ptr<CatalogueDb>> CatalogueDb::Open(const std::filesystem::path& path) {
  Result<SqliteDb> db = SqliteDb::Open(path, OpenMode::kReadWriteCreate);
  if (!db) return db.error();
  const Result<void> tuned = db->Exec("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;");
  if (!tuned) return tuned.error();
  const Result<void> migrated = Migrate(*db);
  if (!migrated) return migrated.error();
  return std::unique_ptr<CatalogueDb>(new CatalogueDb(std::move(*db)));
}

}  // namespace skyquilt::storage
