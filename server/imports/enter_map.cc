#include "server/imports/enter_map.h"

#include <system_error>

#include "core/base/try.h"
#include "storage/catalogue/catalogue.h"
#include "storage/files/publish_file.h"
#include "storage/folder/enter_flight.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kFirstRevision = 1;

Result<void> PutInPlace(const storage::OpenedDataFolder& opened, const fs::path& products,
                        const std::string& flight_id) {
  const fs::path place = opened.dir.Revision(flight_id, kFirstRevision);
  SKYQUILT_TRY(storage::SyncFolder(products));
  std::error_code error;
  fs::rename(products, place, error);
  if (error) return storage::FileError("cannot make", place, error.value());
  SKYQUILT_TRY(storage::SyncFolder(opened.dir.Flight(flight_id)));
  storage::DiskFlight on_disk;
  on_disk.id = flight_id;
  on_disk.folder = opened.dir.Flight(flight_id);
  on_disk.revisions = {kFirstRevision};
  SKYQUILT_TRY_ASSIGN(const storage::EnteredFlight entered,
                      storage::EnterFlight(*opened.db, on_disk, std::nullopt));
  if (!entered.revision)
    return Error{ErrorCode::kInternal, "The map was made, but the catalogue did not take it.",
                 place.string()};
  return {};
}

}  // namespace

Result<std::string> EnterMap(const storage::OpenedDataFolder& opened, const fs::path& products,
                             const std::string& name, const std::vector<std::string>& tags) {
  storage::Catalogue catalogue(*opened.db, storage::FlightRecords(opened.dir));
  storage::FlightChange marks;
  marks.tags = tags;
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight,
                      catalogue.AddFlight(name, "{}", storage::Now(), "", marks));
  const Result<void> placed = PutInPlace(opened, products, flight.id);
  if (placed) return flight.id;
  // The flight is this call's own and was shown to nobody.
  std::error_code stays;  // the sweep of the next server moves it to lost/
  fs::rename(opened.dir.Revision(flight.id, kFirstRevision), products, stays);
  (void)catalogue.DeleteFlight(flight.id).ok();
  return placed.error();
}

}  // namespace skyquilt::server
