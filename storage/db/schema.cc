#include "storage/db/schema.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

#include "core/base/try.h"

namespace skyquilt::storage {

extern const std::string_view kCatalogueSchema;  // storage/db/schema.sql
extern const std::string_view kCatalogue13To14;  // storage/db/steps/schema_14.sql
extern const std::string_view kCatalogue14To15;  // storage/db/steps/schema_15.sql
extern const std::string_view kCatalogue15To16;  // storage/db/steps/schema_16.sql
extern const std::string_view kCatalogue16To17;  // storage/db/steps/schema_17.sql
extern const std::string_view kCatalogue17To18;  // storage/db/steps/schema_18.sql
extern const std::string_view kCatalogue18To19;  // storage/db/steps/schema_19.sql
extern const std::string_view kCatalogue19To20;  // storage/db/steps/schema_20.sql
extern const std::string_view kCatalogue20To21;  // storage/db/steps/schema_21.sql
extern const std::string_view kCatalogue21To22;  // storage/db/steps/schema_22.sql
extern const std::string_view kCatalogue22To23;  // storage/db/steps/schema_23.sql
extern const std::string_view kCatalogue23To24;  // storage/db/steps/schema_24.sql

namespace {

constexpr int kFirstVersion = 13;
// From each version since to the next.
constexpr std::array kSteps = {&kCatalogue13To14, &kCatalogue14To15, &kCatalogue15To16, &kCatalogue16To17,
                               &kCatalogue17To18, &kCatalogue18To19, &kCatalogue19To20, &kCatalogue20To21,
                               &kCatalogue21To22, &kCatalogue22To23, &kCatalogue23To24};
static_assert(kFirstVersion + kSteps.size() == kSchemaVersion);

}  // namespace

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

Result<void> PrepareSchema(SqliteDb& db) {
  // Read inside the write lock: another process may be making the tables.
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(db));
  SKYQUILT_TRY_ASSIGN(const std::int64_t user_version, db.Number("PRAGMA user_version"));
  const int version = static_cast<int>(user_version);
  if (version == kSchemaVersion) return {};
  if (version != 0 && (version < kFirstVersion || version > kSchemaVersion)) return OtherVersion(version);
  if (version == 0) {
    SKYQUILT_TRY(db.Exec(std::string(kCatalogueSchema)));
  } else {
    for (int from = version; from < kSchemaVersion; ++from) {
      SKYQUILT_TRY(db.Exec(std::string(*kSteps[static_cast<std::size_t>(from - kFirstVersion)])));
    }
  }
  SKYQUILT_TRY(db.Exec(fmt::format("PRAGMA user_version={}", kSchemaVersion)));
  return transaction.Commit();
}

}  // namespace skyquilt::storage
