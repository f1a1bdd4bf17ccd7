// Patiently: hours of work must not end with a restart of the database: what may be said twice is, for a
// minute, where the catalogue is shared. Any thread.
#pragma once

#include <chrono>
#include <thread>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"

namespace skyquilt::storage {

template <typename Call>
auto Patiently(const CatalogueDb& db, Call call) {
  constexpr std::chrono::minutes kPatience{1};
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (true) {
    auto outcome = call();
    const bool may_pass = !outcome && outcome.error().code == ErrorCode::kUnavailable;
    if (!db.IsShared() || !may_pass || std::chrono::steady_clock::now() > end) return outcome;
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
}

}  // namespace skyquilt::storage
