#include "server/open_storage.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "core/base/text/printable.h"
#include "core/base/try.h"
#include "server/routing/request_log.h"
#include "storage/folder/lost_folder.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/folder/shared_catalogue.h"
#include "storage/folder/sweep.h"
#include "storage/jobs/map_products.h"

namespace skyquilt::server {

Result<Storage> OpenStorage(const std::filesystem::path& root, int readers, int tile_readers,
                            const storage::CataloguePlace& place) {
  SKYQUILT_TRY_ASSIGN(storage::OpenedDataFolder opened, storage::OpenDataFolder(root, readers, place));
  for (const std::string& note : opened.notes) LogEvent(note);
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<storage::CatalogueDb> tiles_db,
                      storage::OpenCatalogueOf(opened.dir, place, tile_readers));
  SKYQUILT_TRY_ASSIGN(storage::DataDirWatch watch,
                      storage::DataDirWatch::Begin(opened.dir, !place.IsPostgres()));
  return Storage{std::move(opened.dir), *std::move(opened.lock), std::move(opened.db), std::move(tiles_db),
                 std::move(watch)};
}

Result<void> Recover(const storage::DataDir& dir, const storage::Catalogue& catalogue,
                     storage::JobQueue& queue, const storage::Previews& previews, storage::UploadSpool& spool,
                     storage::Time age) {
  const storage::Time now = storage::Now();
  SKYQUILT_TRY_ASSIGN(const int released, queue.TakeUpAfterRestart(now));
  if (released > 0)
    LogEvent(fmt::format("after an unclean stop: {} taken up again", Counted(released, "job")));
  SKYQUILT_TRY_ASSIGN(const storage::SweepReport swept, storage::Sweep(dir, catalogue, queue, previews, now));
  SKYQUILT_TRY_ASSIGN(const int expired, spool.RemoveExpired(age));
  if (swept.removed + expired > 0) {
    LogEvent(fmt::format(
        "{} temporary files and folders of this server were removed: uploads that were cut off or expired, "
        "work of jobs that have ended, previews that are drawn anew",
        swept.removed + expired));
  }
  for (const std::string& line : swept.moved) LogEvent(line);
  SKYQUILT_TRY_ASSIGN(const std::vector<std::filesystem::path> stray, spool.StrayFiles());
  storage::LostFolder lost(dir, now);
  for (const std::filesystem::path& path : stray) LogEvent(lost.Take(path, "is no upload in the catalogue"));
  return {};
}

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
