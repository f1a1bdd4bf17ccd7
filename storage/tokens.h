// Tokens: who may use the server, by the SHA-256 of what they show. Made and revoked by the operator's
// command, also while a server runs: it reads them again within a second. Any thread. Errors: kConflict (the
// name is taken), kNotFound, kUnavailable, kIo.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/catalogue_db.h"
#include "storage/clock.h"

namespace skyquilt::storage {

// Each may do what those before it may.
enum class Scope { kRead, kUpload, kAdmin };
const char* ScopeName(Scope scope);
std::optional<Scope> ScopeFrom(std::string_view name);

struct Token {
  std::string id;
  std::string name;
  std::string hash;  // SHA-256, raw
  Scope scope = Scope::kRead;
  Time created;
  std::optional<Time> expires = {};
  std::optional<std::int64_t> most_bytes = {};  // of files stored
  std::optional<std::int64_t> requests_per_minute = {};
};

class Tokens {
 public:
  explicit Tokens(CatalogueDb& db) : db_(db) {}
  Result<void> Add(const Token& token);
  Result<void> Revoke(const std::string& name);
  Result<std::vector<Token>> List() const;
  // The same, from memory where it is younger than a second: for every request.
  Result<std::shared_ptr<const std::vector<Token>>> Known();

 private:
  CatalogueDb& db_;
  std::mutex mutex_;
  std::shared_ptr<const std::vector<Token>> known_;
  std::chrono::steady_clock::time_point read_at_;
};

}  // namespace skyquilt::storage
