#include "storage/catalogue/idempotent_answers.h"

#include "core/base/try.h"

namespace skyquilt::storage {

Result<std::optional<IdempotentAnswer>> IdempotentAnswers::Find(const IdempotencyKey& key, Time now) const {
  const auto db = db_.Read();
  const auto answer_from = [](const Statement& row) {
    const auto fingerprint = row.ColumnBlob(0);
    return IdempotentAnswer{{fingerprint.begin(), fingerprint.end()},
                            row.Get<int>(1),
                            row.Get<std::string>(2),
                            row.Get<std::string>(3)};
  };
  return db->First(answer_from,
                   "SELECT fingerprint, status, location, body FROM idempotent_answer WHERE owner=? AND key=?"
                   " AND route=? AND created_us>?",
                   key.owner, key.key, key.route, ToUs(now - kKeptFor));
}

Result<void> IdempotentAnswers::Keep(const IdempotencyKey& key, const IdempotentAnswer& answer, Time now) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Change("DELETE FROM idempotent_answer WHERE created_us<=?", ToUs(now - kKeptFor)));
  const std::span<const std::uint8_t> fingerprint(
      reinterpret_cast<const std::uint8_t*>(answer.fingerprint.data()), answer.fingerprint.size());
  SKYQUILT_TRY(db->Change(
      "INSERT INTO idempotent_answer VALUES(?,?,?,?,?,?,?,?) ON CONFLICT(owner,key,route) DO UPDATE SET"
      " fingerprint=excluded.fingerprint, status=excluded.status, location=excluded.location,"
      " body=excluded.body, created_us=excluded.created_us",
      key.owner, key.key, key.route, fingerprint, answer.status, answer.location, answer.body, ToUs(now)));
  return db->Change(
      "DELETE FROM idempotent_answer WHERE owner=?1 AND created_us<(SELECT created_us FROM idempotent_answer"
      " WHERE owner=?1 ORDER BY created_us DESC LIMIT 1 OFFSET ?2)",
      key.owner, kMaxOfOwner - 1);
}

}  // namespace skyquilt::storage
