// SqliteError: turns a SQLite result code and its message into one of our errors. Any thread.
#pragma once

#include <string_view>

#include "core/base/result.h"

struct sqlite3;

namespace skyquilt::storage {

// `what` says what was tried, e.g. "open catalogue.db".
Error SqliteError(int sqlite_code, std::string_view what, std::string_view library_message);
// Of the call on `db` that failed last: a write beyond the size that a file of this process may have
// (RLIMIT_FSIZE) found as little room as one on a full disk.
Error SqliteErrorOf(sqlite3* db, int sqlite_code, std::string_view what);

}  // namespace skyquilt::storage
