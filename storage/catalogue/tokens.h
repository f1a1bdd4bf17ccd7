// Tokens: who may use the server, by the SHA-256 of the token. Made and revoked by the operator's command,
// also while a server runs: it reads them again within a second. That there has been a token is remembered
// when none is left: the server then admits nobody until LetEverybodyIn. Any thread. Errors: kConflict (the
// name is taken), kNotFound, kUnavailable, kIo.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"
#include "storage/db/outage/read_again.h"

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
  std::optional<std::int64_t> max_bytes = {};  // of files stored
  std::optional<std::int64_t> requests_per_minute = {};
  std::string flight_id = {};  // the one flight that it opens, for reading; empty: every flight

  bool HasEnded(Time now) const { return expires && *expires <= now; }
};

// All tokens, and whether the server requires one at all.
struct TokenSet {
  bool requires_token = false;
  std::vector<Token> tokens;  // those that have ended among them

  bool HasLiveOne(Time now) const;
};

class Tokens {
 public:
  static constexpr std::chrono::minutes kTrusted{10};
  static constexpr std::chrono::milliseconds kFreshFor{1000};
  // For a token that is not among those known: one that a command made just now is good at once.
  static constexpr std::chrono::milliseconds kFreshForUnknown{10};
  explicit Tokens(CatalogueDb& db) : db_(db) {}
  Result<void> Add(const Token& token);
  // One that opens a flight. It closes no server that asks nobody for a token.
  Result<void> AddShare(const Token& token);
  // A link's exports end with it (EndExportsOf).
  Result<void> Revoke(const std::string& name);
  // A token of this flight alone, and its exports; kNotFound for any other.
  Result<void> RevokeShare(const std::string& flight_id, const std::string& id);
  Result<TokenSet> Read() const;
  // Until the next token is made, nobody needs one. What `serve --open` says where no token is left.
  Result<void> LetEverybodyIn();
  // The same, from memory where it is younger than `fresh_for`: for every request. While a database that many
  // machines share does not answer, what was read in the last kTrusted holds.
  Result<std::shared_ptr<const TokenSet>> Known(std::chrono::milliseconds fresh_for = kFreshFor);
  // Whether the server requires a token, as Known found it last; read from memory except the first time.
  bool RequiresToken();

 private:
  Result<void> ReadIntoMemory();
  bool HasChanged() const { return changes_ != known_changes_; }
  CatalogueDb& db_;
  std::mutex mutex_;                              // of known_ and read_at_
  std::atomic<std::uint64_t> changes_ = 0;        // that were made here
  std::atomic<std::uint64_t> known_changes_ = 0;  // of these, in known_
  std::atomic<bool> was_read_ = false;
  std::atomic<bool> requires_token_ = true;
  std::shared_ptr<const TokenSet> known_;
  std::chrono::steady_clock::time_point read_at_;
  ReadAgain again_;  // last: its thread uses all of the above
};

// For the transaction that ends a link: what it asked for and was not made yet is forgotten, whose maker
// learns of it at its next heartbeat; what was made has expired.
Result<void> EndExportsOf(SqlConnection& db, const std::string& owner);

}  // namespace skyquilt::storage
