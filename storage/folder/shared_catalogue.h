// The catalogue of a data folder, wherever it lies: catalogue.db in it, or PostgreSQL, where the folder holds
// the files alone. Errors: as of CatalogueDb, and kConflict (the catalogue belongs to another data folder).
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

// Opens one that is there.
Result<std::unique_ptr<CatalogueDb>> OpenCatalogueOf(const DataDir& dir, const CataloguePlace& place,
                                                     int readers = 2);
// In PostgreSQL: makes one where there is none.
Result<std::unique_ptr<CatalogueDb>> MakeSharedCatalogue(const DataDir& dir, const CataloguePlace& place,
                                                         int readers = 2);
// For a new folder: the id that it has to have: that of the catalogue, which gets one where it has none. A
// catalogue with flights belongs to the folder that has their files, and is refused, unless no folder has
// them; so is one whose photos lie elsewhere than `place` says.
Result<std::string> IdForNewFolder(CatalogueDb& db, const CataloguePlace& place);
// The refusal of a folder whose catalogue is in PostgreSQL, where that was not said: a second catalogue
// beside it would know neither its tokens nor its jobs.
Error WantsItsCatalogue(const DataDir& dir);
// "catalogue.db" with its folder, or what to call one in PostgreSQL.
std::string NameOfCatalogue(const DataDir& dir, const CataloguePlace& place);
}  // namespace skyquilt::storage
