// Trash: deleted flights that can be restored. Their files stay in place; for everyone else (Catalogue,
// JobQueue, Previews, NodeTasks and UploadSpool) they do not exist until they are restored, or removed
// permanently with Catalogue::DeleteFlight. They still count towards their owner's quota. Their days count by
// the AgeClock. Any thread. Errors: kNotFound (no such flight, or not in the trash), kOutOfSpace,
// kUnavailable, kIo.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "storage/catalogue/catalogue.h"
#include "storage/catalogue/flight_record.h"
#include "storage/db/catalogue_db.h"

namespace skyquilt::storage {

struct TrashedFlight {
  std::string id;
  std::string name;
  Time created;
  std::int64_t file_count = 0;
  std::int64_t bytes = 0;  // of the uploaded files
  Time deleted;            // by the machine's clock of then
  Time deleted_age;        // by the AgeClock
  std::string owner;       // id of the token that made it; empty without one
};

class Trash {
 public:
  // `records`: where it is written down beside the flights' files as well, for a repair of a lost catalogue.
  explicit Trash(CatalogueDb& db, std::optional<FlightRecords> records = std::nullopt)
      : db_(db), records_(std::move(records)) {}
  // Its job, if one waits or runs, is cancelled with it; its preview goes, to be drawn again should it come
  // back.
  Result<void> Put(const std::string& flight_id, Time now);
  // The same if `is_wanted` says so of what it reads in the transaction that puts it there; false: it is
  // where it was.
  using Condition = std::function<Result<bool>(SqlConnection&)>;
  Result<bool> PutIf(const std::string& flight_id, Time now, const Condition& is_wanted);
  Result<void> Restore(const std::string& flight_id);
  // The latest deleted first.
  Result<std::vector<TrashedFlight>> List() const;
  Result<TrashedFlight> Find(const std::string& flight_id) const;
  // Deleted at or before a time of the AgeClock.
  Result<std::vector<std::string>> DeletedUntil(Time age) const;

 private:
  void Record(const std::string& flight_id, std::optional<Time> trashed) const;

  CatalogueDb& db_;
  std::optional<FlightRecords> records_;
};

}  // namespace skyquilt::storage
