// NodeDeliveries: ends of tasks of the NodeODM-compatible node that are still to be told to the address that
// came with the task. A trigger of the database writes them (storage/db/schema.sql). Any thread, any number
// of processes, of which one delivers. Errors: kUnavailable, kOutOfSpace, kIo.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

struct NodeDelivery {
  std::string uuid;  // of the task
  std::string job_id;
  std::string url;
  int attempts = 0;  // that failed
};

class NodeDeliveries {
 public:
  explicit NodeDeliveries(CatalogueDb& db) : db_(db) {}

  Result<std::vector<NodeDelivery>> Due(Time now, int limit) const;
  // Before it is told. False: another server of the same catalogue has taken it, or it was heard.
  Result<bool> Take(const NodeDelivery& delivery, Time now);
  // Also of one of which nobody needs to hear any more.
  Result<void> Heard(const NodeDelivery& delivery);
  // Tried again later, as other webhooks are.
  Result<void> NotHeard(const NodeDelivery& delivery, Time now);

 private:
  CatalogueDb& db_;
};

}  // namespace skyquilt::storage
