// PrepareSchema: makes the tables of an empty catalogue, in one transaction, accepts one that has them, and
// brings one of version 13 or 14 to the present one. A catalogue of any other schema version, older or newer,
// is refused with kConflict and left as it is. Several processes may call it at once.
#pragma once

#include "core/base/result.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

Result<void> PrepareSchema(SqliteDb& db);

}  // namespace skyquilt::storage
