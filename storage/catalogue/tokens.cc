#include "storage/catalogue/tokens.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/base/check.h"
#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

constexpr std::array kScopeNames = {"read", "upload", "admin"};

std::span<const std::uint8_t> Bytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

Result<void> InsertToken(SqlConnection& db, const Token& token) {
  const std::optional<std::int64_t> expires_us =
      token.expires ? std::optional(ToUs(*token.expires)) : std::nullopt;
  const std::optional<std::string> flight_id =
      token.flight_id.empty() ? std::nullopt : std::optional(token.flight_id);
  Result<void> inserted = db.Change(
      "INSERT INTO token(id,name,hash,scope,created_us,expires_us,most_bytes,requests_per_minute,flight_id)"
      " VALUES(?,?,?,?,?,?,?,?,?)",
      token.id, token.name, Bytes(token.hash), ScopeName(token.scope), ToUs(token.created), expires_us,
      token.max_bytes, token.requests_per_minute, flight_id);
  if (!inserted && inserted.error().code == ErrorCode::kConflict) {
    return Error{ErrorCode::kConflict, fmt::format("There is a token named \"{}\" already.", token.name), ""};
  }
  return inserted;
}

Result<bool> AsksForToken(SqlConnection& db) {
  SKYQUILT_TRY_ASSIGN(const std::optional<bool> asks,
                      db.First(FirstColumn<bool>, "SELECT asks_for_token FROM token_policy"));
  return asks.value_or(true);
}

}  // namespace

const char* ScopeName(Scope scope) { return kScopeNames[static_cast<std::size_t>(scope)]; }

std::optional<Scope> ScopeFrom(std::string_view name) {
  for (const Scope scope : {Scope::kRead, Scope::kUpload, Scope::kAdmin}) {
    if (name == ScopeName(scope)) return scope;
  }
  return std::nullopt;
}

bool TokenSet::HasLiveOne(Time now) const {
  return std::any_of(tokens.begin(), tokens.end(), [&](const Token& token) { return !token.HasEnded(now); });
}

Result<void> Tokens::Add(const Token& token) {
  const auto db = db_.Lock();
  Result<void> inserted = InsertToken(*db, token);
  ++changes_;
  return inserted;
}

Result<void> Tokens::AddShare(const Token& token) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
  // Held from here on: a first token that is made elsewhere meanwhile comes before or after, and closes the
  // server either way. The catalogue takes every new token for a first one; a share is none.
  SKYQUILT_TRY(db->Exec("UPDATE token_policy SET asks_for_token=asks_for_token"));
  SKYQUILT_TRY_ASSIGN(const bool asked, AsksForToken(*db));
  SKYQUILT_TRY(InsertToken(*db, token));
  if (!asked) SKYQUILT_TRY(db->Exec("UPDATE token_policy SET asks_for_token=0"));
  SKYQUILT_TRY(transaction.Commit());
  ++changes_;
  return {};
}

Result<void> Tokens::Revoke(const std::string& name) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> links,
                      db->AllText("SELECT id FROM token WHERE name=? AND flight_id IS NOT NULL", name));
  for (const std::string& id : links) SKYQUILT_TRY(EndExportsOf(*db, id));
  SKYQUILT_TRY(db->Change("DELETE FROM token WHERE name=?", name));
  if (db->Changes() == 0)
    return Error{ErrorCode::kNotFound, fmt::format("There is no token named \"{}\".", name), ""};
  SKYQUILT_TRY(transaction.Commit());
  ++changes_;
  return {};
}

Result<void> Tokens::RevokeShare(const std::string& flight_id, const std::string& id) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
  SKYQUILT_TRY(db->Change("DELETE FROM token WHERE id=? AND flight_id=?", id, flight_id));
  if (db->Changes() == 0)
    return Error{ErrorCode::kNotFound, "This flight has no such share. It may have been revoked.", ""};
  SKYQUILT_TRY(EndExportsOf(*db, id));
  SKYQUILT_TRY(transaction.Commit());
  ++changes_;
  return {};
}

Result<void> Tokens::LetEverybodyIn() {
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Exec("UPDATE token_policy SET asks_for_token=0"));
  ++changes_;
  return {};
}

Result<TokenSet> Tokens::Read() const {
  const auto db = db_.Read();
  const auto token_from = [](const Statement& row) {
    Token token;
    std::string scope_name;
    row.Into(token.id, token.name, scope_name, token.created, token.expires, token.max_bytes,
             token.requests_per_minute, token.flight_id);
    const std::optional<Scope> scope = ScopeFrom(scope_name);
    SKYQUILT_CHECK(scope.has_value(), "the schema allows no other scope");
    token.scope = *scope;
    const auto hash = row.ColumnBlob(8);
    token.hash.assign(hash.begin(), hash.end());
    return token;
  };
  TokenSet set;
  SKYQUILT_TRY_ASSIGN(
      set.tokens, db->All(token_from,
                          "SELECT id, name, scope, created_us, expires_us, most_bytes, requests_per_minute,"
                          " flight_id, hash FROM token ORDER BY id"));
  // Asked after the list: a token that is made in between closes the server, and never is one left out that
  // opens it.
  SKYQUILT_TRY_ASSIGN(set.requires_token, AsksForToken(*db));
  return set;
}

Result<void> Tokens::ReadIntoMemory() {
  const auto now = std::chrono::steady_clock::now();
  const std::uint64_t changes = changes_;
  SKYQUILT_TRY_ASSIGN(TokenSet tokens, Read());
  const std::lock_guard lock(mutex_);
  // One that began later was done first, and may know of a change that this one does not.
  if (known_ != nullptr && now < read_at_) return {};
  known_changes_ = changes;
  known_ = std::make_shared<const TokenSet>(std::move(tokens));
  read_at_ = now;
  requires_token_ = known_->requires_token;
  was_read_ = true;
  return {};
}

Result<std::shared_ptr<const TokenSet>> Tokens::Known(std::chrono::milliseconds fresh_for) {
  const auto now = std::chrono::steady_clock::now();
  bool has_changed = false;
  std::shared_ptr<const TokenSet> known;
  {
    const std::lock_guard lock(mutex_);
    has_changed = HasChanged();
    if (!has_changed && known_ != nullptr && now - read_at_ < fresh_for) return known_;
    if (now - read_at_ < kTrusted) known = known_;
  }
  // What was changed here is never answered from before.
  const bool may_be_late = db_.IsShared() && !has_changed && known != nullptr;
  const Result<void> read =
      may_be_late ? again_.Ask("tokens", [this] { return ReadIntoMemory(); }) : ReadIntoMemory();
  if (!read && may_be_late && read.error().code == ErrorCode::kUnavailable) return known;
  if (!read) return read.error();
  const std::lock_guard lock(mutex_);
  return known_;
}

bool Tokens::RequiresToken() {
  // A catalogue that cannot be read opens nothing.
  if (!was_read_ || HasChanged()) return !Known() || requires_token_;
  return requires_token_;
}

Result<void> EndExportsOf(SqlConnection& db, const std::string& owner) {
  for (const char* sql : {"DELETE FROM map_export WHERE owner=? AND state IN ('accepted','running')",
                          "UPDATE map_export SET expires_us=0 WHERE owner=?"}) {
    SKYQUILT_TRY(db.Change(sql, owner));
  }
  return {};
}

}  // namespace skyquilt::storage
