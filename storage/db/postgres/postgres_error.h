// PostgresError: turns an SQLSTATE of PostgreSQL and its message into one of our errors. Any thread.
#pragma once

#include <string_view>

#include "core/base/result.h"

namespace skyquilt::storage {

// `what` says what was tried; `sqlstate` is empty where the library itself gave up.
Error PostgresError(std::string_view sqlstate, std::string_view what, std::string_view server_message);
// The server was not reached, or went away.
Error LostConnection(std::string_view what, std::string_view library_message);
// Undone by the server because of what others did at the same time: the same again is right.
bool IsConflictOfWriters(std::string_view sqlstate);

}  // namespace skyquilt::storage
