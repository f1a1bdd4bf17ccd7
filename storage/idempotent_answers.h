// IdempotentAnswers: what was answered to a request under a key that its client chose, so that the same
// request sent again (the answer got lost) is answered the same and does nothing twice. Kept for a day of the AgeClock. Any
// thread. Errors: kUnavailable, kOutOfSpace, kIo.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "storage/catalogue_db.h"
#include "storage/clock.h"

namespace skyquilt::storage {

struct IdempotentAnswer {
  std::string fingerprint;  // of the request's body
  int status = 0;
  std::string location;
  std::string body;
};

class IdempotentAnswers {
 public:
  static constexpr std::chrono::hours kKeptFor{24};
  explicit IdempotentAnswers(CatalogueDb& db) : db_(db) {}
  Result<std::optional<IdempotentAnswer>> Find(const std::string& key, const std::string& route,
                                               Time now) const;
  // Also forgets those that are too old.
  Result<void> Keep(const std::string& key, const std::string& route, const IdempotentAnswer& answer,
                    Time now);

 private:
  CatalogueDb& db_;
};

}  // namespace skyquilt::storage
