#include "storage/db/postgres/postgres_error.h"

#include <fmt/format.h>

#include "core/flight/remarks/because.h"

namespace skyquilt::storage {

Error LostConnection(std::string_view what, std::string_view library_message) {
  return flight::Because(ErrorCode::kUnavailable, flight::RemarkCode::kFailDatabaseAway,
                         fmt::format("postgresql: {}: {}", library_message, what));
}

bool IsConflictOfWriters(std::string_view sqlstate) { return sqlstate == "40001" || sqlstate == "40P01"; }

Error PostgresError(std::string_view sqlstate, std::string_view what, std::string_view server_message) {
  const std::string detail = fmt::format("postgresql {} ({}): {}", sqlstate, server_message, what);
  const std::string_view kind = sqlstate.substr(0, 2);
  if (kind == "23")
    return {ErrorCode::kConflict, "This exists already, or something it belongs to does not.", detail};
  if (sqlstate == "53100") {
    return {ErrorCode::kOutOfSpace,
            "The disk of the catalogue's database is full. Free some space there and try again.", detail};
  }
  if (sqlstate.empty() || kind == "08" || kind == "53" || kind == "57" || kind == "58") {
    return LostConnection(what, server_message);
  }
  if (kind == "40" || sqlstate == "55P03") {
    return {ErrorCode::kUnavailable, "The database is in use by another program. Try again in a moment.",
            detail};
  }
  if (sqlstate == "22021" || sqlstate == "22P05") {
    return {ErrorCode::kInvalidArgument,
            "A text has characters that cannot be stored. Send it as UTF-8, without zero bytes.", detail};
  }
  if (sqlstate == "54000") return {ErrorCode::kTooLarge, "A value is too large for the database.", detail};
  if (sqlstate == "25006") {
    return {ErrorCode::kUnavailable,
            "The catalogue's database only reads: it may be a standby. Connect to its primary.", detail};
  }
  if (kind == "28" || sqlstate == "42501") {
    return {
        ErrorCode::kForbidden,
        "The catalogue's database refuses this to its user. Check user and password, and grant the user CREATE "
        "and USAGE on its schema.",
        detail};
  }
  if (kind == "3D" || kind == "3F") {
    return {ErrorCode::kNotFound,
            "The catalogue's database or schema does not exist. Make it, or mend --catalogue.", detail};
  }
  if (kind == "XX") {
    return {ErrorCode::kCorrupt,
            "The catalogue's database is damaged. Restore it from a backup, or make the catalogue anew with "
            "\"skyquilt data repair\".",
            detail};
  }
  return {ErrorCode::kIo, "The database could not be read or written.", detail};
}

}  // namespace skyquilt::storage
