// Webhooks: who is to be notified of ended jobs and new maps, and the deliveries still to be made. Deliveries
// are rows that triggers of the database write (storage/db/schema_sqlite.sql). Any thread, any number of
// processes, of which one delivers. Errors: kNotFound, kUnavailable, kOutOfSpace, kIo.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

struct Webhook {
  std::string id;
  std::string url;
  std::string secret;
  Time created;
};

struct Delivery {
  Webhook webhook;
  std::int64_t event_seq = 0;
  std::string body;
  int attempts = 0;  // that failed
};

// For as long a message that one server has taken is no other's; longer than a receiver may take to answer.
inline constexpr std::chrono::minutes kDeliveryTurn{2};
inline constexpr int kMaxDeliveryAttempts = 8;  // the last one some twenty minutes after the first
// Until the next attempt, after so many that failed.
inline std::chrono::seconds DeliveryPause(int attempts) { return std::chrono::seconds{10} * (1 << attempts); }

class Webhooks {
 public:
  explicit Webhooks(CatalogueDb& db) : db_(db) {}
  Result<Webhook> Add(const std::string& url, const std::string& secret, Time now);
  Result<std::vector<Webhook>> List() const;
  Result<void> Remove(const std::string& id);

  // Oldest first, of each webhook up to `limit`.
  Result<std::vector<Delivery>> Due(Time now, int limit) const;
  // Before it is sent. False: another server of the same catalogue has taken it, or it was heard.
  Result<bool> Take(const Delivery& delivery, Time now);
  Result<void> Heard(const Delivery& delivery);
  // Tried again later, each time after twice as long; given up after kMaxDeliveryAttempts.
  Result<void> NotHeard(const Delivery& delivery, Time now);

 private:
  CatalogueDb& db_;
};

}  // namespace skyquilt::storage
