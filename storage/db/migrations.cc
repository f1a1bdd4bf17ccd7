#include "storage/db/migrations.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

namespace skyquilt::storage {

extern const std::string_view kSchema0001;  // storage/db/schema/0001_catalogue.sql
extern const std::string_view kSchema0002;  // storage/db/schema/0002_tasks_and_events.sql
extern const std::string_view kSchema0003;  // storage/db/schema/0003_uploads.sql
extern const std::string_view kSchema0004;  // storage/db/schema/0004_tokens.sql
extern const std::string_view kSchema0005;  // storage/db/schema/0005_previews.sql
extern const std::string_view kSchema0006;  // storage/db/schema/0006_sharing.sql
extern const std::string_view kSchema0007;  // storage/db/schema/0007_webhooks.sql
extern const std::string_view kSchema0008;  // storage/db/schema/0008_upload_owner.sql
extern const std::string_view kSchema0009;  // storage/db/schema/0009_turns.sql
extern const std::string_view kSchema0010;  // storage/db/schema/0010_interruptions.sql
extern const std::string_view kSchema0011;  // storage/db/schema/0011_trash.sql
extern const std::string_view kSchema0012;  // storage/db/schema/0012_data_dir.sql
extern const std::string_view kSchema0013;  // storage/db/schema/0013_access.sql

namespace {

// Step i brings version i to i + 1. Only ever appended to.
const std::array kSteps = {&kSchema0001, &kSchema0002, &kSchema0003, &kSchema0004, &kSchema0005,
                           &kSchema0006, &kSchema0007, &kSchema0008, &kSchema0009, &kSchema0010,
                           &kSchema0011, &kSchema0012, &kSchema0013};

Result<int> CurrentVersion(SqliteDb& db) {
  Result<Statement> query = db.Prepare("PRAGMA user_version");
  if (!query) return query.error();
  const Result<bool> row = query->Step();
  if (!row) return row.error();
  return static_cast<int>(query->ColumnInt64(0));
}

}  // namespace

int NewestSchemaVersion() { return static_cast<int>(kSteps.size()); }

Result<void> Migrate(SqliteDb& db) {
  while (true) {
    // Read again inside the write lock: another process may be doing the same.
    Result<Transaction> transaction = Transaction::Begin(db);
    if (!transaction) return transaction.error();
    const Result<int> version = CurrentVersion(db);
    if (!version) return version.error();
    if (*version == NewestSchemaVersion()) return {};
    if (*version > NewestSchemaVersion()) {
      return Error{ErrorCode::kConflict,
                   "This data folder was written by a newer Skyquilt. Use that version, or another folder.",
                   fmt::format("schema {} against {}", *version, NewestSchemaVersion())};
    }
    const Result<void> stepped = db.Exec(std::string(*kSteps[static_cast<std::size_t>(*version)]));
    if (!stepped) return stepped.error();
    const Result<void> marked = db.Exec(fmt::format("PRAGMA user_version={}", *version + 1));
    if (!marked) return marked.error();
    const Result<void> done = transaction->Commit();
    if (!done) return done.error();
  }
}

}  // namespace skyquilt::storage
