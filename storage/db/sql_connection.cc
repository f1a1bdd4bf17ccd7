#include "storage/db/sql_connection.h"

#include "core/base/check.h"

namespace skyquilt::storage {

Result<std::int64_t> Statement::Number() {
  SKYQUILT_TRY_ASSIGN(const auto number, First(FirstColumn<std::int64_t>));
  return number.value_or(0);
}

Result<void> Statement::Run() {
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, Step());
    if (!row) break;
  }
  Reset();
  return {};
}

Result<Transaction> Transaction::Begin(SqlConnection& db, std::string_view flight) {
  SKYQUILT_TRY(db.BeginTransaction(flight));
  return Transaction(db);
}

Result<void> Transaction::Commit() {
  const Result<void> committed = db_->CommitTransaction();
  if (committed) static_cast<void>(db_.release());
  db_.reset();
  return committed;
}

Result<UnsyncedCommits> UnsyncedCommits::Begin(SqlConnection& db) {
  SKYQUILT_TRY(db.SyncCommits(false));
  return UnsyncedCommits(db);
}

void UnsyncedCommits::SyncAgain::operator()(SqlConnection* db) const {
  const Result<void> synced = db->SyncCommits(true);
  SKYQUILT_CHECK(synced.ok(), "commits can wait for the disk again");
}

}  // namespace skyquilt::storage
