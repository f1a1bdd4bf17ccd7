// Migrate: brings a catalogue to the newest schema, one transaction a step, forward only. A catalogue of a
// newer Skyquilt is refused with kConflict and left as it is. Safe when several processes start at once.
#pragma once

#include "core/base/result.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

Result<void> Migrate(SqliteDb& db);
int NewestSchemaVersion();

}  // namespace skyquilt::storage
