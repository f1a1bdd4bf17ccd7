// The place of photos and maps as the operator chose it, settled for this catalogue
// (storage/folder/object_store/settle_blobs). Errors: those of OpenBlobs and SettleBlobs.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "storage/blobs/open_blobs.h"
#include "storage/db/catalogue_db.h"
#include "storage/files/data_dir.h"

namespace skyquilt::server {

Result<std::shared_ptr<storage::BlobStore>> OpenBlobsOf(const storage::DataDir& dir, storage::CatalogueDb& db,
                                                        const storage::BlobPlace& place);

}  // namespace skyquilt::server
