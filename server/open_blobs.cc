#include "server/open_blobs.h"

#include "core/base/try.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/jobs/map_products.h"

namespace skyquilt::server {

Result<std::shared_ptr<storage::BlobStore>> OpenBlobsOf(const storage::DataDir& dir, storage::CatalogueDb& db,
                                                        const storage::BlobPlace& place) {
  SKYQUILT_TRY_ASSIGN(std::shared_ptr<storage::BlobStore> blobs,
                      storage::OpenBlobs(place, dir.root(), [&db](const std::string& key) {
                        return storage::PublishedSum(db, key);
                      }));
  SKYQUILT_TRY(storage::SettleBlobs(dir, db, *blobs));
  return blobs;
}

}  // namespace skyquilt::server
