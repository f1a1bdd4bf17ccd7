#include "storage/db/sqlite_statement.h"

#include <sqlite3.h>

#include "core/base/check.h"
#include "storage/db/sqlite_error.h"

namespace skyquilt::storage {
namespace {

// NOLINTNEXTLINE(performance-no-int-to-ptr): SQLite's own constant, which no caller may do without
const sqlite3_destructor_type kCopied = SQLITE_TRANSIENT;

void RequireBound(int code) { SKYQUILT_CHECK(code == SQLITE_OK, "a parameter that the SQL does not have"); }

Error StepError(sqlite3_stmt* handle, int code) {
  sqlite3* db = sqlite3_db_handle(handle);
  const char* sql = sqlite3_sql(handle);
  return SqliteErrorOf(db, sqlite3_extended_errcode(db) != SQLITE_OK ? sqlite3_extended_errcode(db) : code,
                       sql != nullptr ? sql : "");
}

}  // namespace

SqliteStatement::~SqliteStatement() { sqlite3_finalize(handle_); }

void SqliteStatement::BindInt64(int index, std::int64_t value) {
  RequireBound(sqlite3_bind_int64(handle_, index, value));
}

void SqliteStatement::BindDouble(int index, double value) {
  RequireBound(sqlite3_bind_double(handle_, index, value));
}

void SqliteStatement::BindText(int index, std::string_view value) {
  const char* text = value.data() != nullptr ? value.data() : "";
  RequireBound(sqlite3_bind_text64(handle_, index, text, value.size(), kCopied, SQLITE_UTF8));
}

void SqliteStatement::BindBlob(int index, std::span<const std::uint8_t> value) {
  static constexpr std::uint8_t kNothing = 0;
  const void* bytes = value.data() != nullptr ? value.data() : &kNothing;
  RequireBound(sqlite3_bind_blob64(handle_, index, bytes, value.size(), kCopied));
}

void SqliteStatement::BindNull(int index) { RequireBound(sqlite3_bind_null(handle_, index)); }

Result<bool> SqliteStatement::Step() {
  const int code = sqlite3_step(handle_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  const Error error = StepError(handle_, code);
  sqlite3_reset(handle_);
  return error;
}

void SqliteStatement::Reset() { sqlite3_reset(handle_); }

std::int64_t SqliteStatement::ColumnInt64(int column) const { return sqlite3_column_int64(handle_, column); }
double SqliteStatement::ColumnDouble(int column) const { return sqlite3_column_double(handle_, column); }

std::string_view SqliteStatement::ColumnText(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(handle_, column));
  if (text == nullptr) return {};
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}

std::span<const std::uint8_t> SqliteStatement::ColumnBlob(int column) const {
  const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(handle_, column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}

bool SqliteStatement::IsNull(int column) const { return sqlite3_column_type(handle_, column) == SQLITE_NULL; }

}  // namespace skyquilt::storage
