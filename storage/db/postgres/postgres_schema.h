// PreparePostgres: makes the tables of the catalogue in the schema of this connection, and the schema where
// the place names one, in one transaction; accepts tables of this version. A catalogue of another version, or
// tables that are not a catalogue's, are refused with kConflict and left as they are. Several processes may
// call it at once: the first makes them. Errors: kNotFound (`may_make` is false and there are none),
// kForbidden, kUnavailable, kIo.
#pragma once

#include "core/base/result.h"
#include "storage/db/postgres/postgres_db.h"

namespace skyquilt::storage {

Result<void> PreparePostgres(PostgresDb& db, const CataloguePlace& place, bool may_make);

}  // namespace skyquilt::storage
