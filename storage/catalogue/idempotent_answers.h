// IdempotentAnswers: answers to requests under a key that the client chose, so that the same request sent
// again (because its answer was lost) is answered the same and not carried out twice. Each token has its own
// keys, and the newest of them are kept, for a day of the AgeClock. Any thread. Errors: kUnavailable,
// kOutOfSpace, kIo.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

// Which request an answer belongs to.
struct IdempotencyKey {
  std::string owner;  // id of the token that sent it; empty without one
  std::string key;
  std::string route;  // method and path
};

struct IdempotentAnswer {
  std::string fingerprint;  // of what the request's body says
  int status = 0;
  std::string location;
  std::string body;
};

class IdempotentAnswers {
 public:
  static constexpr std::chrono::hours kKeptFor{24};
  // A link that only reads has keys, too: of exports.
  static constexpr int kMaxOfOwner = 1000;
  explicit IdempotentAnswers(CatalogueDb& db) : db_(db) {}
  Result<std::optional<IdempotentAnswer>> Find(const IdempotencyKey& key, Time now) const;
  // Also forgets those that are too old or too many.
  Result<void> Keep(const IdempotencyKey& key, const IdempotentAnswer& answer, Time now);

 private:
  CatalogueDb& db_;
};

}  // namespace skyquilt::storage
