// PrepareSchema: makes the tables of an empty catalogue, in one transaction, accepts one that has them, and
// brings one of version 13 or later to the present one. A catalogue of any other schema version, older or
// newer, is refused with kConflict and left as it is. Several processes may call it at once.
#pragma once

#include "core/base/result.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

// Grows with every change of schema.sql. Versions 1 to 12 were those of development before the first release.
inline constexpr int kSchemaVersion = 24;

Result<void> PrepareSchema(SqliteDb& db);

// What a catalogue of another version is refused with, in every engine.
Error OtherVersion(int version);

}  // namespace skyquilt::storage
