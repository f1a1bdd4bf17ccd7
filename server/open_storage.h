// The server's side of its data folder and its store: opens them (storage/folder/open_data_folder,
// storage/blobs/open_blobs), cleans up after a crash, and logs what it did. Errors: those of what it opens.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "storage/blobs/open_blobs.h"
#include "storage/catalogue/previews.h"
#include "storage/db/catalogue_db.h"
#include "storage/files/data_dir.h"
#include "storage/folder/data_dir_watch.h"
#include "storage/folder/open_data_folder.h"
#include "storage/jobs/job_queue.h"
#include "storage/uploads/upload_spool.h"

namespace skyquilt::server {

struct Storage {
  storage::DataDir dir;
  storage::DataDirLock lock;
  std::unique_ptr<storage::CatalogueDb> db;
  std::unique_ptr<storage::CatalogueDb> tiles_db;  // tiles never wait for a write of the others
  storage::DataDirWatch watch;
};

// `readers`, `tile_readers`: how many may read at the same time from each of the two.
Result<Storage> OpenStorage(const std::filesystem::path& root, int readers, int tile_readers,
                            const storage::CataloguePlace& place = {});

// Leases of dead workers are given back; what belongs nowhere goes to lost/, and only what this server wrote
// as temporary is removed. Before requests are taken. `age`: now, by the catalogue's AgeClock.
Result<void> Recover(const storage::DataDir& dir, const storage::Catalogue& catalogue,
                     storage::JobQueue& queue, const storage::Previews& previews, storage::UploadSpool& spool,
                     storage::Time age);

// The place of photos and maps as the operator chose it, settled for this catalogue
// (storage/folder/object_store/settle_blobs).
Result<std::shared_ptr<storage::BlobStore>> OpenBlobsOf(const storage::DataDir& dir, storage::CatalogueDb& db,
                                                        const storage::BlobPlace& place);

}  // namespace skyquilt::server
