#include "storage/db/sqlite_error.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cerrno>

namespace skyquilt::storage {

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

Error SqliteErrorOf(sqlite3* db, int sqlite_code, std::string_view what) {
  const bool is_beyond_limit = sqlite_code == SQLITE_IOERR_WRITE && sqlite3_system_errno(db) == EFBIG;
  return SqliteError(is_beyond_limit ? SQLITE_FULL : sqlite_code, what, sqlite3_errmsg(db));
}

}  // namespace skyquilt::storage
