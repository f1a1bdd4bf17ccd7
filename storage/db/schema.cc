#include "storage/db/schema.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"

namespace skyquilt::storage {

extern const std::string_view kCatalogueSchema;    // storage/db/schema.sql
extern const std::string_view kSqliteSchema;       // storage/db/schema_sqlite.sql
extern const std::string_view kPostgresTables;     // storage/db/postgres/schema_postgres.sql
extern const std::string_view kPostgresFunctions;  // storage/db/postgres/functions_postgres.sql
extern const std::string_view kCatalogueSteps;     // storage/db/schema_steps.sql

namespace {

constexpr int kFirstVersion = 13, kFirstPostgresVersion = 16;

// SQL as it is written for SQLite, in the words of the connection's engine. Texts are compared by their bytes
// in either.
std::string WordsFor(const SqlConnection& db, std::string_view sql) {
  std::string words(sql);
  if (db.dialect() == Dialect::kSqlite) return words;
  using Word = std::pair<std::string_view, std::string_view>;
  constexpr std::array kInPostgres = {Word{"CAST(strftime('%s', 'now') AS INTEGER) * 1000000", "now_us()"},
                                      Word{" TEXT", " TEXT COLLATE \"C\""},
                                      Word{" INTEGER", " BIGINT"},
                                      Word{" REAL", " DOUBLE PRECISION"},
                                      Word{" BLOB", " BYTEA"},
                                      Word{") STRICT;", ");"}};
  for (const auto& [from, to] : kInPostgres) {
    for (std::size_t at = words.find(from); at != std::string::npos; at = words.find(from, at + to.size()))
      words.replace(at, from.size(), to);
  }
  return words;
}

// A catalogue of an earlier version to this one.
Result<void> StepFrom(SqlConnection& db, int version) {
  const std::size_t begin = kCatalogueSteps.find(fmt::format("-- To version {}:", version + 1));
  SKYQUILT_CHECK(begin != std::string_view::npos, "each version has a step to the next");
  return db.Exec(WordsFor(db, kCatalogueSteps.substr(begin)));
}

// What a catalogue of another version is refused with, in every engine.
Error OtherVersion(int version) {
  return {
      ErrorCode::kConflict,
      version > kSchemaVersion
          ? "This data folder was written by a newer Skyquilt. Use that version, or another folder."
          : "The catalogue of this data folder is from before the first release of Skyquilt and cannot be "
            "read. Use another folder, or move catalogue.db and the files named catalogue.db-... out of this "
            "one and let \"skyquilt data repair\" make the catalogue anew from the flights on disk.",
      fmt::format("schema {} against {}", version, kSchemaVersion)};
}

}  // namespace

Result<void> PrepareSchema(SqliteDb& db) {
  // Read inside the write lock: another process may be making the tables.
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(db));
  SKYQUILT_TRY_ASSIGN(const std::int64_t user_version, db.Number("PRAGMA user_version"));
  const int version = static_cast<int>(user_version);
  if (version == kSchemaVersion) return {};
  if (version != 0 && (version < kFirstVersion || version > kSchemaVersion)) return OtherVersion(version);
  if (version == 0) {
    SKYQUILT_TRY(db.Exec(WordsFor(db, kCatalogueSchema)));
    SKYQUILT_TRY(db.Exec(std::string(kSqliteSchema)));
  } else {
    SKYQUILT_TRY(StepFrom(db, version));
  }
  SKYQUILT_TRY(db.Exec(fmt::format("PRAGMA user_version={}", kSchemaVersion)));
  return transaction.Commit();
}

namespace {

Result<bool> HasTable(SqlConnection& db, std::string_view name) {
  return db.Finds("SELECT 1 FROM pg_tables WHERE schemaname=current_schema() AND tablename=?", name);
}

// 0: no catalogue.
Result<int> PostgresVersion(SqlConnection& db) {
  SKYQUILT_TRY_ASSIGN(const bool is_there, HasTable(db, "catalogue_version"));
  if (!is_there) return 0;
  SKYQUILT_TRY_ASSIGN(const std::int64_t version, db.Number("SELECT version FROM catalogue_version"));
  return static_cast<int>(version);
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
  if (version >= kFirstPostgresVersion && version < kSchemaVersion) {
    // No table can be altered while an event of its rows waits for the commit.
    SKYQUILT_TRY(db.Exec("SET CONSTRAINTS ALL IMMEDIATE"));
    SKYQUILT_TRY(StepFrom(db, version));
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
  SKYQUILT_TRY(db.Exec(WordsFor(db, kCatalogueSchema)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgresTables)));
  SKYQUILT_TRY(db.Exec(std::string(kPostgresFunctions)));
  SKYQUILT_TRY(db.Exec(fmt::format("INSERT INTO catalogue_version VALUES(1, {}, pg_postmaster_start_time())",
                                   kSchemaVersion)));
  return transaction.Commit();
}

}  // namespace skyquilt::storage
