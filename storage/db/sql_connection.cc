#include "storage/db/sql_connection.h"

#include "core/base/check.h"
#include "core/base/try.h"

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

Transaction::Transaction(Transaction&& other) noexcept : db_(std::exchange(other.db_, nullptr)) {}

Transaction::~Transaction() {
  if (db_ != nullptr) db_->RollbackTransaction();
}

Result<void> Transaction::Commit() {
  SKYQUILT_TRY(db_->CommitTransaction());
  db_ = nullptr;
  return {};
}

Result<UnsyncedCommits> UnsyncedCommits::Begin(SqlConnection& db) {
  SKYQUILT_TRY(db.SyncCommits(false));
  return UnsyncedCommits(db);
}

UnsyncedCommits::UnsyncedCommits(UnsyncedCommits&& other) noexcept : db_(std::exchange(other.db_, nullptr)) {}

UnsyncedCommits::~UnsyncedCommits() {
  if (db_ == nullptr) return;
  const Result<void> synced = db_->SyncCommits(true);
  SKYQUILT_CHECK(synced.ok(), "commits can wait for the disk again");
}

}  // namespace skyquilt::storage
