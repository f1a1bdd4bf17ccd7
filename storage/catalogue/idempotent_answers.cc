#include "storage/catalogue/idempotent_answers.h"

#include "core/base/try.h"

namespace skyquilt::storage {

Result<std::optional<IdempotentAnswer>> IdempotentAnswers::Find(const IdempotencyKey& key, Time now) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Prepare(
          "SELECT fingerprint, status, location, body FROM idempotent_answer WHERE owner=? AND key=? AND "
          "route=? AND created_us>?"));
  SKYQUILT_TRY_ASSIGN(
      const bool row,
      query.Bind(1, key.owner).Bind(2, key.key).Bind(3, key.route).Bind(4, ToUs(now - kKeptFor)).Step());
  if (!row) return std::optional<IdempotentAnswer>();
  IdempotentAnswer answer;
  const auto fingerprint = query.ColumnBlob(0);
  answer.fingerprint.assign(fingerprint.begin(), fingerprint.end());
  answer.status = static_cast<int>(query.ColumnInt64(1));
  answer.location = query.ColumnText(2);
  answer.body = query.ColumnText(3);
  return std::optional<IdempotentAnswer>(std::move(answer));
}

Result<void> IdempotentAnswers::Keep(const IdempotencyKey& key, const IdempotentAnswer& answer, Time now) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement forget, db->Prepare("DELETE FROM idempotent_answer WHERE created_us<=?"));
  SKYQUILT_TRY(forget.Bind(1, ToUs(now - kKeptFor)).Run());
  SKYQUILT_TRY_ASSIGN(
      Statement insert,
      db->Prepare(
          "INSERT INTO idempotent_answer VALUES(?,?,?,?,?,?,?,?) ON CONFLICT(owner,key,route) DO UPDATE SET"
          " fingerprint=excluded.fingerprint, status=excluded.status, location=excluded.location,"
          " body=excluded.body, created_us=excluded.created_us"));
  const std::span<const std::uint8_t> fingerprint(
      reinterpret_cast<const std::uint8_t*>(answer.fingerprint.data()), answer.fingerprint.size());
  return insert.Bind(1, key.owner)
      .Bind(2, key.key)
      .Bind(3, key.route)
      .Bind(4, fingerprint)
      .Bind(5, answer.status)
      .Bind(6, answer.location)
      .Bind(7, answer.body)
      .Bind(8, ToUs(now))
      .Run();
}

}  // namespace skyquilt::storage
