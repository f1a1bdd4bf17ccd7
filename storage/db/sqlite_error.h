// SqliteError: turns a SQLite result code and its message into one of our errors. Any thread.
#pragma once

#include <string_view>

#include "core/base/result.h"

namespace skyquilt::storage {

// `what` says what was tried, e.g. "open catalogue.db".
Error SqliteError(int sqlite_code, std::string_view what, std::string_view library_message);

}  // namespace skyquilt::storage
