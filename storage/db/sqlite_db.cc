#include "storage/db/sqlite_db.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <memory>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"
#include "storage/db/immutable/read_ahead.h"
#include "storage/db/sqlite_error.h"
#include "storage/db/sqlite_statement.h"

namespace skyquilt::storage {
namespace {

constexpr int kBusyTimeoutMs = 10'000;

// A path as a SQLite URI: everything but plain characters is escaped, so that '?' and '%' in a folder stay a
// path.
std::string UriOf(const std::filesystem::path& path) {
  std::string uri = "file:";
  for (const unsigned char c : std::filesystem::absolute(path).string()) {
    const bool is_plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                          c == '/' || c == '.' || c == '_' || c == '-';
    if (is_plain) {
      uri.push_back(static_cast<char>(c));
    } else {
      uri += fmt::format("%{:02X}", static_cast<unsigned>(c));
    }
  }
  return uri + "?immutable=1";
}

}  // namespace

Result<SqliteDb> SqliteDb::Open(const std::filesystem::path& path, OpenMode mode) {
  sqlite3* handle = nullptr;
  // NOMUTEX: the connection is used by one thread at a time, which this class demands of its caller.
  // A reader of a WAL needs to write its index beside the file; query_only keeps it from writing more.
  const int flags = mode == OpenMode::kReadWriteCreate
                        ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX
                    : mode == OpenMode::kReadShared || mode == OpenMode::kReadWrite
                        ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX
                        : SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
  const std::string name =
      mode == OpenMode::kReadOnlyImmutable ? UriOf(path) : std::filesystem::absolute(path).string();
  const char* const vfs = mode == OpenMode::kReadOnlyImmutable ? ReadAheadVfs() : nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &handle, flags, vfs);
  SqliteDb db(handle);
  if (code == SQLITE_CANTOPEN && mode == OpenMode::kReadWriteCreate) {
    return Error{ErrorCode::kIo,
                 fmt::format("{} cannot be written. Choose a folder that exists and that you may write to.",
                             path.string()),
                 handle != nullptr ? sqlite3_errmsg(handle) : ""};
  }
  if (code != SQLITE_OK) {
    return SqliteError(code, "open " + path.string(), handle != nullptr ? sqlite3_errmsg(handle) : "");
  }
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_timeout(handle, kBusyTimeoutMs);
  const Result<void> ready = db.Exec(
      mode == OpenMode::kReadShared          ? "PRAGMA query_only=1; SELECT count(*) FROM sqlite_master;"
      : mode == OpenMode::kReadOnlyImmutable ? "PRAGMA query_only=1; PRAGMA cache_size=-64;"
                                               "PRAGMA trusted_schema=0; SELECT count(*) FROM sqlite_master;"
                                             : "PRAGMA foreign_keys=1; SELECT count(*) FROM sqlite_master;");
  if (!ready)
    return Error{ready.error().code, ready.error().message, path.string() + ": " + ready.error().detail};
  return db;
}

SqliteDb::~SqliteDb() { sqlite3_close_v2(handle_); }

SqliteDb::SqliteDb(SqliteDb&& other) noexcept
    : SqlConnection(std::move(other)), handle_(std::exchange(other.handle_, nullptr)) {}

SqliteDb& SqliteDb::operator=(SqliteDb&& other) noexcept {
  if (this != &other) {
    sqlite3_close_v2(handle_);
    handle_ = std::exchange(other.handle_, nullptr);
  }
  return *this;
}

Result<void> SqliteDb::Exec(const std::string& sql) {
  const int code = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return SqliteErrorOf(handle_, code, sql);
  return {};
}

Result<Statement> SqliteDb::Prepare(std::string_view sql) {
  sqlite3_stmt* handle = nullptr;
  const int code = sqlite3_prepare_v3(handle_, sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &handle, nullptr);
  if (code != SQLITE_OK) return SqliteError(code, sql, sqlite3_errmsg(handle_));
  return Statement(std::make_unique<SqliteStatement>(handle));
}

std::int64_t SqliteDb::Changes() const { return sqlite3_changes64(handle_); }

Result<void> SqliteDb::Close() {
  const int code = sqlite3_close(handle_);
  SKYQUILT_CHECK(code != SQLITE_BUSY, "a database was closed before its statements");
  handle_ = nullptr;
  if (code != SQLITE_OK) return SqliteError(code, "close", "");
  return {};
}

Result<void> SqliteDb::BeginTransaction(std::string_view /*flight*/) { return Exec("BEGIN IMMEDIATE"); }
Result<void> SqliteDb::CommitTransaction() { return Exec("COMMIT"); }

// After a failed COMMIT SQLite may have rolled back by itself; then this ROLLBACK fails and nothing is lost.
void SqliteDb::RollbackTransaction() { static_cast<void>(Exec("ROLLBACK")); }

Result<void> SqliteDb::SyncCommits(bool on) {
  return Exec(on ? "PRAGMA synchronous=FULL; PRAGMA wal_autocheckpoint=1000;"
                 : "PRAGMA synchronous=NORMAL; PRAGMA wal_autocheckpoint=0;");
}

}  // namespace skyquilt::storage
