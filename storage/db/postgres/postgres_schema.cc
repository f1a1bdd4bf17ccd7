#include "storage/db/postgres/postgres_schema.h"

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "core/base/try.h"
#include "storage/db/schema.h"

namespace skyquilt::storage {

extern const std::string_view kPostgresTables;     // storage/db/postgres/schema_postgres.sql
extern const std::string_view kPostgresFunctions;  // storage/db/postgres/functions_postgres.sql
extern const std::string_view kPostgres16To17;     // storage/db/postgres/schema_17_postgres.sql
extern const std::string_view kPostgres17To18;     // storage/db/postgres/schema_18_postgres.sql
extern const std::string_view kPostgres18To19;     // storage/db/postgres/schema_19_postgres.sql
extern const std::string_view kPostgres19To20;     // storage/db/postgres/schema_20_postgres.sql
extern const std::string_view kPostgres20To21;     // storage/db/postgres/schema_21_postgres.sql
extern const std::string_view kPostgres21To22;     // storage/db/postgres/schema_22_postgres.sql
extern const std::string_view kPostgres22To23;     // storage/db/postgres/schema_23_postgres.sql
extern const std::string_view kPostgres23To24;     // storage/db/postgres/schema_24_postgres.sql

namespace {

Result<bool> HasTable(SqlConnection& db, std::string_view name) {
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db.Prepare("SELECT 1 FROM pg_tables WHERE schemaname=current_schema() AND tablename=?"));
  return query.Bind(1, name).Step();
}

// 0: no catalogue.
Result<int> PostgresVersion(SqlConnection& db) {
  SKYQUILT_TRY_ASSIGN(const bool is_there, HasTable(db, "catalogue_version"));
  if (!is_there) return 0;
  SKYQUILT_TRY_ASSIGN(Statement query, db.Prepare("SELECT version FROM catalogue_version"));
  SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
  return row ? static_cast<int>(query.ColumnInt64(0)) : 0;
}

}  // namespace

Result<void> PreparePostgres(PostgresDb& db, const CataloguePlace& place, bool may_make) {
  const Result<int> looked = PostgresVersion(db);
  if (!looked) {
    // The operator reads this, not a client: what the library says helps him, and has no password in it.
    const Error& error = looked.error();
    return Error{error.code, error.message + " (" + error.detail.substr(0, error.detail.rfind(": ")) + ")",
                 error.detail};
  }
  const int seen = *looked;
  if (seen == kSchemaVersion) return {};
  const Error none{
      ErrorCode::kNotFound,
      "There is no catalogue in the database of --catalogue yet. Start a server on it to make one.", ""};
  if (seen == 0 && !may_make) return none;
  // Read again inside the lock: another process may be making the tables.
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(db));
  if (!place.schema.empty()) {
    SKYQUILT_TRY(db.Exec(fmt::format("CREATE SCHEMA IF NOT EXISTS \"{}\"", place.schema)));
  } else if (db.schema().empty()) {
    return Error{
        ErrorCode::kNotFound,
        "The search path of the catalogue's database names no schema that exists. Make one, or say which "
        "with ?schema=NAME at the end of --catalogue.",
        ""};
  }
  SKYQUILT_TRY_ASSIGN(const int version, PostgresVersion(db));
  if (version == kSchemaVersion) return {};
  if (version >= 16 && version <= 23) {
    if (version == 16) {
      SKYQUILT_TRY(db.Exec(std::string(kPostgres16To17)));
    }
    if (version <= 17) {
      SKYQUILT_TRY(db.Exec(std::string(kPostgres17To18)));
    }
    if (version <= 18) {
      SKYQUILT_TRY(db.Exec(std::string(kPostgres18To19)));
    }
    if (version <= 19) {
      SKYQUILT_TRY(db.Exec(std::string(kPostgres19To20)));
    }
    if (version <= 20) {
      SKYQUILT_TRY(db.Exec(std::string(kPostgres20To21)));
    }
    if (version <= 21) {
      SKYQUILT_TRY(db.Exec(std::string(kPostgres21To22)));
    }
    if (version <= 22) {
      SKYQUILT_TRY(db.Exec(std::string(kPostgres22To23)));
    }
    SKYQUILT_TRY(db.Exec(std::string(kPostgres23To24)));
    SKYQUILT_TRY(db.Exec(fmt::format("UPDATE catalogue_version SET version={}", kSchemaVersion)));
    return transaction.Commit();
  }
  if (version != 0) return OtherVersion(version);
  SKYQUILT_TRY_ASSIGN(const bool is_anothers, HasTable(db, "flight"));
  if (is_anothers) {
    return Error{
        ErrorCode::kConflict,
        "The database of --catalogue has a table \"flight\" that is not of a catalogue. Choose another "
        "database, or a schema with ?schema=NAME. Nothing was changed.",
        ""};
  }
  SKYQUILT_TRY(db.Exec(std::string(kPostgresTables)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgres16To17)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgres17To18)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgres18To19)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgres19To20)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgres20To21)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgres21To22)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgres22To23)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgres23To24)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgresFunctions)));
  SKYQUILT_TRY(db.Exec(fmt::format("INSERT INTO catalogue_version VALUES(1, {}, pg_postmaster_start_time())",
                                   kSchemaVersion)));
  return transaction.Commit();
}

}  // namespace skyquilt::storage
