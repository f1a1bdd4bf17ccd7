// The tables of a catalogue, in each engine: made where it is empty, in one transaction; accepted where it
// has them; brought to the present version from 13 on (PostgreSQL: 16). A catalogue of any other schema
// version, older or newer, is refused with kConflict and left as it is. Several processes may call these at
// once.
#pragma once

#include "core/base/result.h"
#include "storage/db/postgres/postgres_db.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

// Grows with every change of what the files schema*.sql make, which has its step in schema_steps.sql.
// Versions 1 to 12 were those of development before the first release.
inline constexpr int kSchemaVersion = 24;

Result<void> PrepareSchema(SqliteDb& db);

// In the schema of this connection, which is made too where the place names one. Tables that are not a
// catalogue's are refused as well. Errors: kNotFound (`may_make` is false and there are none), kForbidden,
// kUnavailable, kIo.
Result<void> PreparePostgres(PostgresDb& db, const CataloguePlace& place, bool may_make);

}  // namespace skyquilt::storage
