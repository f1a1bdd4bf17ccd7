#include "storage/folder/shared_catalogue.h"

#include <fmt/format.h>

#include <optional>
#include <system_error>

#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/db/machine_boot.h"
#include "storage/folder/data_marker.h"
#include "storage/folder/object_store/settle_blobs.h"

namespace skyquilt::storage {
namespace {

// This server among those that share a catalogue: its machine and data folder.
std::string NodeOf(const DataDir& dir) {
  std::error_code unresolved;  // then the path as it was given
  const std::filesystem::path resolved = std::filesystem::weakly_canonical(dir.root(), unresolved);
  const std::string path = (unresolved ? dir.root() : resolved).string();
  std::uint32_t hash = 2166136261U;  // FNV-1a
  for (const char c : path) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return fmt::format("{}.{:08x}", MachineBoot::HostName(), hash);
}

}  // namespace

Error WantsItsCatalogue(const DataDir& dir) {
  return {
      ErrorCode::kConflict,
      fmt::format(
          "The catalogue of {} is in PostgreSQL: say --catalogue postgresql://... as its server does. To have it "
          "in the folder again, take \"catalogue\" out of its skyquilt-data.json and run \"skyquilt data repair "
          "--data {}\". Nothing was changed.",
          dir.root().string(), dir.root().string()),
      ""};
}

std::string NameOfCatalogue(const DataDir& dir, const CataloguePlace& place) {
  return place.IsPostgres() ? "in the database of --catalogue" : dir.Catalogue().string();
}

Result<std::unique_ptr<CatalogueDb>> OpenCatalogueOf(const DataDir& dir, const CataloguePlace& place,
                                                     int readers) {
  // Also where a catalogue.db of earlier lies in it: it knows nothing of what came since.
  if (!place.IsPostgres() && HasSharedCatalogue(dir)) return WantsItsCatalogue(dir);
  if (!place.IsPostgres()) return CatalogueDb::OpenExisting(dir.Catalogue(), readers);
  return CatalogueDb::OpenPostgres(place, NodeOf(dir), /*may_make=*/false, readers);
}

Result<std::unique_ptr<CatalogueDb>> MakeSharedCatalogue(const DataDir& dir, const CataloguePlace& place,
                                                         int readers) {
  return CatalogueDb::OpenPostgres(place, NodeOf(dir), /*may_make=*/true, readers);
}

Result<std::string> IdForNewFolder(CatalogueDb& db, const CataloguePlace& place) {
  const auto access = db.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*access));
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> known, CatalogueId(*access));
  SKYQUILT_TRY(CheckBlobsOf(*access, known, place.files_at, place.files_of));
  SKYQUILT_TRY_ASSIGN(const bool has_flights, access->Finds("SELECT 1 FROM flight LIMIT 1"));
  if (known && has_flights && place.files_at.empty()) {
    return Error{
        ErrorCode::kConflict,
        "The catalogue in the database of --catalogue has flights whose files are in another data folder. "
        "Give that folder with --data, or another database or schema. Nothing was changed.",
        ""};
  }
  const std::string id = known.value_or(NewId());
  if (!known) {
    SKYQUILT_TRY(SetCatalogueId(*access, id));
  }
  SKYQUILT_TRY(transaction.Commit());
  return id;
}

}  // namespace skyquilt::storage
