// The marker of a data folder, skyquilt-data.json, and the same id in the catalogue: a folder is ours only
// where the two agree. The marker says {"format": 1, "id": "<26 characters>"}, and "catalogue": "postgresql"
// too where the catalogue is not in the folder; it is written once, when the folder becomes ours. Any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "storage/db/sql_connection.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

// The id in a marker's text. Errors: kCorrupt, kConflict (of a newer Skyquilt).
Result<std::string> ParseMarker(std::string_view text);

// The id of the folder; absent where it has no marker. Errors: kCorrupt, kConflict, kIo.
Result<std::optional<std::string>> ReadMarker(const DataDir& dir);
Result<void> WriteMarker(const DataDir& dir, const std::string& id, bool is_shared = false);
// Whether a folder's marker says that its catalogue is in PostgreSQL.
bool HasSharedCatalogue(const DataDir& dir);

// The id of the folder that a catalogue belongs to; absent in one of a version without markers.
Result<std::optional<std::string>> CatalogueId(SqlConnection& db);
Result<void> SetCatalogueId(SqlConnection& db, const std::string& id);

// Where the photos and maps of a catalogue in PostgreSQL lie, as its first server said: "s3://bucket/prefix/"
// or kInDataFolder; empty where none has yet.
inline constexpr const char* kInDataFolder = "folder";
Result<std::string> CatalogueBlobs(SqlConnection& db);
// Unless it was said before; what holds now.
Result<std::string> SayCatalogueBlobs(SqlConnection& db, const std::string& where);
// They were moved.
Result<void> ChangeCatalogueBlobs(SqlConnection& db, const std::string& where);

}  // namespace skyquilt::storage
