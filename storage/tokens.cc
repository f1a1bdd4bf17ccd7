#include "storage/tokens.h"

#include <fmt/format.h>

#include <array>

#include "core/base/check.h"

namespace skyquilt::storage {
namespace {

constexpr std::array kScopeNames = {"read", "upload", "admin"};
constexpr std::chrono::seconds kFreshFor{1};

std::span<const std::uint8_t> Bytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

const char* ScopeName(Scope scope) { return kScopeNames[static_cast<std::size_t>(scope)]; }

std::optional<Scope> ScopeFrom(std::string_view name) {
  for (const Scope scope : {Scope::kRead, Scope::kUpload, Scope::kAdmin}) {
    if (name == ScopeName(scope)) return scope;
  }
  return std::nullopt;
}

Result<void> Tokens::Add(const Token& token) {
  const auto db = db_.Lock();
  Result<Statement> insert = db->Prepare(
      "INSERT INTO token(id,name,hash,scope,created_us,expires_us,most_bytes,requests_per_minute)"
      " VALUES(?,?,?,?,?,?,?,?)");
  if (!insert) return insert.error();
  insert->Bind(1, token.id).Bind(2, token.name).Bind(3, Bytes(token.hash)).Bind(4, ScopeName(token.scope));
  insert->Bind(5, ToUs(token.created)).BindNull(6);
  if (token.expires) insert->Bind(6, ToUs(*token.expires));
  insert->BindNull(7).BindNull(8);
  if (token.most_bytes) insert->Bind(7, *token.most_bytes);
  if (token.requests_per_minute) insert->Bind(8, *token.requests_per_minute);
  const Result<void> inserted = insert->Run();
  if (!inserted && inserted.error().code == ErrorCode::kConflict) {
    return Error{ErrorCode::kConflict, fmt::format("There is a token named \"{}\" already.", token.name), ""};
  }
  return inserted;
}

Result<void> Tokens::Revoke(const std::string& name) {
  const auto db = db_.Lock();
  Result<Statement> remove = db->Prepare("DELETE FROM token WHERE name=?");
  if (!remove) return remove.error();
  const Result<void> removed = remove->Bind(1, name).Run();
  if (!removed) return removed.error();
  if (db->Changes() == 0)
    return Error{ErrorCode::kNotFound, fmt::format("There is no token named \"{}\".", name), ""};
  return {};
}

Result<std::vector<Token>> Tokens::List() const {
  const auto db = db_.Read();
  Result<Statement> query =
      db->Prepare(
      "SELECT id, name, hash, scope, created_us, expires_us, most_bytes, requests_per_minute FROM token ORDER BY id");
  if (!query) return query.error();
  std::vector<Token> tokens;
  while (true) {
    const Result<bool> row = query->Step();
    if (!row) return row.error();
    if (!*row) return tokens;
    Token token;
    token.id = query->ColumnText(0);
    token.name = query->ColumnText(1);
    const auto hash = query->ColumnBlob(2);
    token.hash.assign(hash.begin(), hash.end());
    const std::optional<Scope> scope = ScopeFrom(query->ColumnText(3));
    SKYQUILT_CHECK(scope.has_value(), "the schema allows no other scope");
    token.scope = *scope;
    token.created = FromUs(query->ColumnInt64(4));
    if (!query->IsNull(5)) token.expires = FromUs(query->ColumnInt64(5));
    if (!query->IsNull(6)) token.most_bytes = query->ColumnInt64(6);
    if (!query->IsNull(7)) token.requests_per_minute = query->ColumnInt64(7);
    tokens.push_back(std::move(token));
  }
}

Result<std::shared_ptr<const std::vector<Token>>> Tokens::Known() {
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  if (known_ != nullptr && now - read_at_ < kFreshFor) return known_;
  Result<std::vector<Token>> tokens = List();
  if (!tokens) return tokens.error();
  known_ = std::make_shared<const std::vector<Token>>(*std::move(tokens));
  read_at_ = now;
  return known_;
}

}  // namespace skyquilt::storage
