#include "storage/db/sqlite_db.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cerrno>

#include "core/base/check.h"
#include "core/base/text/percent.h"
#include "core/base/try.h"
#include "storage/db/read_ahead.h"

namespace skyquilt::storage {
namespace {

// One of our errors from a code of SQLite and its message. `what` says what was tried, e.g. "open
// catalogue.db".
Error SqliteError(int sqlite_code, std::string_view what, std::string_view library_message) {
  const std::string detail = fmt::format("sqlite {} ({}): {}", sqlite_code, library_message, what);
  // The memory that readers and writers share is a file beside the database, and can find no room either.
  if (sqlite_code == SQLITE_IOERR_SHMSIZE) return SqliteError(SQLITE_FULL, what, library_message);
  switch (sqlite_code & 0xff) {
    case SQLITE_FULL:
      return {ErrorCode::kOutOfSpace, "The disk is full. Free some space and try again.", detail};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return {
          ErrorCode::kCorrupt,
          "A database file is damaged. Put back a good copy of it. A map is made anew by running its job again; "
          "for a server's catalogue stop the server and run \"skyquilt data check\".",
          detail};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorCode::kUnavailable, "The database is in use by another program. Try again in a moment.",
              detail};
    case SQLITE_CONSTRAINT:
      return {ErrorCode::kConflict, "This exists already, or something it belongs to does not.", detail};
    case SQLITE_CANTOPEN:
      return {ErrorCode::kNotFound, "A database file cannot be opened: it is missing or not readable.",
              detail};
    case SQLITE_TOOBIG:
      return {ErrorCode::kTooLarge, "A value is too large for the database.", detail};
    case SQLITE_NOMEM:
      return {ErrorCode::kUnavailable, "The machine is out of memory. Try again with less running.", detail};
    default:
      return {ErrorCode::kIo, "The database could not be read or written.", detail};
  }
}

// Of the call on `db` that failed last: a write beyond the size that a file of this process may have
// (RLIMIT_FSIZE) found as little room as one on a full disk.
Error SqliteErrorOf(sqlite3* db, int sqlite_code, std::string_view what) {
  const bool is_beyond_limit = sqlite_code == SQLITE_IOERR_WRITE && sqlite3_system_errno(db) == EFBIG;
  return SqliteError(is_beyond_limit ? SQLITE_FULL : sqlite_code, what, sqlite3_errmsg(db));
}

// NOLINTNEXTLINE(performance-no-int-to-ptr): SQLite's own constant, which no caller may do without
const sqlite3_destructor_type kCopied = SQLITE_TRANSIENT;

void RequireBound(int code) { SKYQUILT_CHECK(code == SQLITE_OK, "a parameter that the SQL does not have"); }

Error StepError(sqlite3_stmt* handle, int code) {
  sqlite3* db = sqlite3_db_handle(handle);
  const char* sql = sqlite3_sql(handle);
  return SqliteErrorOf(db, sqlite3_extended_errcode(db) != SQLITE_OK ? sqlite3_extended_errcode(db) : code,
                       sql != nullptr ? sql : "");
}

// A Statement's driver over SQLite. Owns the library's statement.
class SqliteStatement final : public StatementDriver {
 public:
  explicit SqliteStatement(sqlite3_stmt* handle) : handle_(handle) {}
  ~SqliteStatement() override { sqlite3_finalize(handle_); }

  void BindInt64(int index, std::int64_t value) override {
    RequireBound(sqlite3_bind_int64(handle_, index, value));
  }

  void BindDouble(int index, double value) override {
    RequireBound(sqlite3_bind_double(handle_, index, value));
  }

  void BindText(int index, std::string_view value) override {
    const char* text = value.data() != nullptr ? value.data() : "";
    RequireBound(sqlite3_bind_text64(handle_, index, text, value.size(), kCopied, SQLITE_UTF8));
  }

  void BindBlob(int index, std::span<const std::uint8_t> value) override {
    static constexpr std::uint8_t kNothing = 0;
    const void* bytes = value.data() != nullptr ? value.data() : &kNothing;
    RequireBound(sqlite3_bind_blob64(handle_, index, bytes, value.size(), kCopied));
  }

  void BindNull(int index) override { RequireBound(sqlite3_bind_null(handle_, index)); }

  Result<bool> Step() override {
    const int code = sqlite3_step(handle_);
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) return false;
    const Error error = StepError(handle_, code);
    sqlite3_reset(handle_);
    return error;
  }

  void Reset() override { sqlite3_reset(handle_); }

  std::int64_t ColumnInt64(int column) const override { return sqlite3_column_int64(handle_, column); }
  double ColumnDouble(int column) const override { return sqlite3_column_double(handle_, column); }

  std::string_view ColumnText(int column) const override {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(handle_, column));
    if (text == nullptr) return {};
    return {text, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
  }

  std::span<const std::uint8_t> ColumnBlob(int column) const override {
    const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(handle_, column));
    if (bytes == nullptr) return {};
    return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
  }

  bool IsNull(int column) const override { return sqlite3_column_type(handle_, column) == SQLITE_NULL; }

 private:
  sqlite3_stmt* handle_;
};

constexpr int kBusyTimeoutMs = 10'000;

// A path as a SQLite URI: everything but plain characters is escaped, so that '?' and '%' in a folder stay a
// path.
std::string UriOf(const std::filesystem::path& path) {
  return "file:" + PercentEncoded(std::filesystem::absolute(path).string(), "/._-") + "?immutable=1";
}

}  // namespace

void SqliteBlobs::Closer::operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }

std::optional<std::string> SqliteBlobs::Read(std::int64_t row_id) {
  if (db_ == nullptr) return std::nullopt;
  int code = SQLITE_OK;
  if (blob_ != nullptr) {
    code = sqlite3_blob_reopen(blob_.get(), row_id);
  } else {
    sqlite3_blob* opened = nullptr;
    code = sqlite3_blob_open(db_, "main", table_.c_str(), column_.c_str(), row_id, 0, &opened);
    blob_.reset(opened);
  }
  if (code == SQLITE_OK && sqlite3_blob_bytes(blob_.get()) > sqlite3_limit(db_, SQLITE_LIMIT_LENGTH, -1))
    code = SQLITE_TOOBIG;
  std::string bytes;
  if (code == SQLITE_OK) {
    bytes.resize(static_cast<std::size_t>(sqlite3_blob_bytes(blob_.get())));
    const ReadingValue reading(static_cast<std::int64_t>(bytes.size()));
    code = sqlite3_blob_read(blob_.get(), bytes.data(), static_cast<int>(bytes.size()), 0);
  }
  if (code == SQLITE_OK) return bytes;
  blob_.reset();
  db_ = nullptr;
  return std::nullopt;
}

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
  const char* const settings =
      mode == OpenMode::kReadShared ? "PRAGMA query_only=1;"
      : mode == OpenMode::kReadOnlyImmutable
          ? "PRAGMA query_only=1; PRAGMA cache_size=-64; PRAGMA mmap_size=1; PRAGMA trusted_schema=0;"
          : "PRAGMA foreign_keys=1;";
  const Result<void> ready = db.Exec(std::string(settings) + "SELECT count(*) FROM sqlite_master;");
  if (!ready)
    return Error{ready.error().code, ready.error().message, path.string() + ": " + ready.error().detail};
  return db;
}

void SqliteDb::CountNoMemory() { static_cast<void>(sqlite3_config(SQLITE_CONFIG_MEMSTATUS, 0)); }

void SqliteDb::Closer::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }

Result<void> SqliteDb::Exec(const std::string& sql) {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return SqliteErrorOf(handle_.get(), code, sql);
  return {};
}

Result<Statement> SqliteDb::Prepare(std::string_view sql) {
  sqlite3_stmt* handle = nullptr;
  const int code = sqlite3_prepare_v3(handle_.get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &handle, nullptr);
  if (code != SQLITE_OK) return SqliteError(code, sql, sqlite3_errmsg(handle_.get()));
  return Statement(std::make_unique<SqliteStatement>(handle));
}

void SqliteDb::LimitValues(std::uint64_t max_bytes) {
  sqlite3_limit(handle_.get(), SQLITE_LIMIT_LENGTH, static_cast<int>(max_bytes));
}

std::int64_t SqliteDb::Changes() const { return sqlite3_changes64(handle_.get()); }

Result<void> SqliteDb::Close() {
  const int code = sqlite3_close(handle_.get());
  SKYQUILT_CHECK(code != SQLITE_BUSY, "a database was closed before its statements");
  static_cast<void>(handle_.release());
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
