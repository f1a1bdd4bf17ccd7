#include "storage/catalogue/idempotent_answers.h"

#include "core/base/try.h"

namespace skyquilt::storage {

Result<std::optional<IdempotentAnswer>> IdempotentAnswers::Find(const IdempotencyKey& key, Time now) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Query(
          "SELECT fingerprint, status, location, body FROM idempotent_answer WHERE owner=? AND key=? AND "
          "route=? AND created_us>?",
          key.owner, key.key, key.route, ToUs(now - kKeptFor)));
  return query.First([](const Statement& row) {
    IdempotentAnswer answer;
    const auto fingerprint = row.ColumnBlob(0);
    answer.fingerprint.assign(fingerprint.begin(), fingerprint.end());
    answer.status = static_cast<int>(row.ColumnInt64(1));
    answer.location = row.ColumnText(2);
    answer.body = row.ColumnText(3);
    return answer;
  });
}

Result<void> IdempotentAnswers::Keep(const IdempotencyKey& key, const IdempotentAnswer& answer, Time now) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Change("DELETE FROM idempotent_answer WHERE created_us<=?", ToUs(now - kKeptFor)));
  const std::span<const std::uint8_t> fingerprint(
      reinterpret_cast<const std::uint8_t*>(answer.fingerprint.data()), answer.fingerprint.size());
  return db->Change(
      "INSERT INTO idempotent_answer VALUES(?,?,?,?,?,?,?,?) ON CONFLICT(owner,key,route) DO UPDATE SET"
      " fingerprint=excluded.fingerprint, status=excluded.status, location=excluded.location,"
      " body=excluded.body, created_us=excluded.created_us",
      key.owner, key.key, key.route, fingerprint, answer.status, answer.location, answer.body, ToUs(now));
}

}  // namespace skyquilt::storage
