// SqliteDb: one connection to one SQLite file. Errors of the library are translated here: SQLITE_FULL to
// kOutOfSpace, SQLITE_CORRUPT and SQLITE_NOTADB to kCorrupt, SQLITE_BUSY to kUnavailable, a constraint to
// kConflict, a missing file to kNotFound, the rest to kIo. A connection is used by one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "storage/db/statement.h"

struct sqlite3;

namespace skyquilt::storage {

enum class OpenMode {
  kReadWriteCreate,    // waits up to 10 s for another writer
  kReadShared,         // only reads a file that others write (WAL): waits for none of them
  kReadWrite,          // the same, of a file that exists; kNotFound else
  kReadOnlyImmutable,  // the file never changes again: no locks. Not mapped: a hundred maps would count as
                       // this process's memory, and a page that cannot be read would end it
};

class SqliteDb {
 public:
  static Result<SqliteDb> Open(const std::filesystem::path& path, OpenMode mode);
  SqliteDb() = default;
  ~SqliteDb();
  SqliteDb(SqliteDb&& other) noexcept;
  SqliteDb& operator=(SqliteDb&& other) noexcept;
  SqliteDb(const SqliteDb&) = delete;
  SqliteDb& operator=(const SqliteDb&) = delete;

  // One or several statements without parameters; rows are dropped.
  Result<void> Exec(const std::string& sql);
  Result<Statement> Prepare(std::string_view sql);
  // Rows changed by the last INSERT, UPDATE or DELETE.
  std::int64_t Changes() const;
  std::int64_t LastInsertRowId() const;
  bool is_open() const { return handle_ != nullptr; }
  // Closes now, so that a failure to flush can be seen. Statements must be gone.
  Result<void> Close();

 private:
  explicit SqliteDb(sqlite3* handle) : handle_(handle) {}
  sqlite3* handle_ = nullptr;
};

// BEGIN IMMEDIATE now; ROLLBACK at the end of the scope unless Commit was called.
class Transaction {
 public:
  static Result<Transaction> Begin(SqliteDb& db);
  ~Transaction();
  Transaction(Transaction&& other) noexcept;
  Transaction& operator=(Transaction&&) = delete;
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  Result<void> Commit();

 private:
  explicit Transaction(SqliteDb& db) : db_(&db) {}
  SqliteDb* db_;
};

// While it lives, commits of this connection do not wait for the disk, and leave checkpoints to later ones. A
// power cut may undo them, last ones first; the end of a process does not, and the file stays whole (WAL).
// The next commit that waits takes them along. Made and ended outside of transactions.
class UnsyncedCommits {
 public:
  static Result<UnsyncedCommits> Begin(SqliteDb& db);
  ~UnsyncedCommits();
  UnsyncedCommits(UnsyncedCommits&& other) noexcept;
  UnsyncedCommits& operator=(UnsyncedCommits&&) = delete;
  UnsyncedCommits(const UnsyncedCommits&) = delete;
  UnsyncedCommits& operator=(const UnsyncedCommits&) = delete;

 private:
  explicit UnsyncedCommits(SqliteDb& db) : db_(&db) {}
  SqliteDb* db_;
};

}  // namespace skyquilt::storage
