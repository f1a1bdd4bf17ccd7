// SqliteDb: one connection to one SQLite file. Errors of the library are translated here: SQLITE_FULL to
// kOutOfSpace, SQLITE_CORRUPT and SQLITE_NOTADB to kCorrupt, SQLITE_BUSY to kUnavailable, a constraint to
// kConflict, a missing file to kNotFound, the rest to kIo. A connection is used by one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/result.h"
#include "storage/db/sql_connection.h"

struct sqlite3;
struct sqlite3_blob;

namespace skyquilt::storage {

enum class OpenMode {
  kReadWriteCreate,    // waits up to 10 s for another writer
  kReadShared,         // only reads a file that others write (WAL): waits for none of them
  kReadWrite,          // the same, of a file that exists; kNotFound else
  kReadOnlyImmutable,  // the file never changes again: no locks. Not mapped: a hundred maps would count as
                       // this process's memory, and a page that cannot be read would end it
};

// SqliteBlobs: values of one column of a table with row ids, read straight into the caller's memory, where a
// statement copies them once more. After the first one that it cannot read (no such row or table, no bytes,
// more of them than LimitValues lets, a damaged file) it reads none: a statement says what is wrong. Must not
// outlive its database.
class SqliteBlobs {
 public:
  SqliteBlobs() = default;
  SqliteBlobs(sqlite3* db, std::string table, std::string column)
      : db_(db), table_(std::move(table)), column_(std::move(column)) {}
  std::optional<std::string> Read(std::int64_t row_id);

 private:
  struct Closer {
    void operator()(sqlite3_blob* blob) const;
  };
  sqlite3* db_ = nullptr;  // null: none is to be read
  std::string table_, column_;
  std::unique_ptr<sqlite3_blob, Closer> blob_;  // goes from row to row
};

class SqliteDb final : public SqlConnection {
 public:
  static Result<SqliteDb> Open(const std::filesystem::path& path, OpenMode mode);
  // Called before anything uses SQLite, whose count of its memory takes a lock of the process at each block.
  static void CountNoMemory();
  SqliteDb() = default;

  Result<void> Exec(const std::string& sql) override;
  Result<Statement> Prepare(std::string_view sql) override;
  std::int64_t Changes() const override;
  SqliteBlobs Blobs(std::string table, std::string column) const {
    return {handle_.get(), std::move(table), std::move(column)};
  }
  // Of larger values none is read: kTooLarge.
  void LimitValues(std::uint64_t max_bytes);
  Dialect dialect() const override { return Dialect::kSqlite; }
  bool is_open() const { return handle_ != nullptr; }
  // Closes now, so that a failure to flush can be seen. Statements must be gone.
  Result<void> Close();

 private:
  explicit SqliteDb(sqlite3* handle) : handle_(handle) {}
  Result<void> BeginTransaction(std::string_view flight) override;
  Result<void> CommitTransaction() override;
  void RollbackTransaction() override;
  Result<void> SyncCommits(bool on) override;
  struct Closer {
    void operator()(sqlite3* handle) const;
  };
  std::unique_ptr<sqlite3, Closer> handle_;
};

}  // namespace skyquilt::storage
