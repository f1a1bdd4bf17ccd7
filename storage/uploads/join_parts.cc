// UploadSpool::Join: the parts of an upload become one.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/uploads/upload_spool.h"

namespace skyquilt::storage {

Result<std::optional<SpooledUpload>> UploadSpool::JoinedBefore(const SpooledUpload& wish, Time now) const {
  std::string id;
  {
    const auto db = db_.Read();
    SKYQUILT_TRY_ASSIGN(
        id, db->Text("SELECT id FROM upload WHERE flight_id=? AND owner=? AND concat=? AND name=?",
                     wish.flight_id, wish.owner, wish.concat, wish.name));
  }
  if (id.empty()) return std::optional<SpooledUpload>();
  SKYQUILT_TRY_ASSIGN(SpooledUpload upload, Read(id, now));
  return std::optional(std::move(upload));
}

Result<std::vector<SpooledUpload>> UploadSpool::CompleteParts(const std::vector<std::string>& parts,
                                                              Time now) const {
  std::vector<SpooledUpload> complete;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    SKYQUILT_TRY_ASSIGN(SpooledUpload part, Read(parts[i], now));
    if (!part.IsPart())
      return Error{
          ErrorCode::kConflict,
          fmt::format("The upload {} is not a part: it was begun without Upload-Concat: partial.", parts[i]),
          ""};
    if (part.offset != part.length)
      return Error{ErrorCode::kConflict,
                   fmt::format("Part {} of {} is not complete: send the rest of its bytes first.", i + 1,
                               parts.size()),
                   ""};
    complete.push_back(std::move(part));
  }
  return complete;
}

Result<void> UploadSpool::EnterJoined(const SpooledUpload& joined,
                                      const std::vector<SpooledUpload>& parts) const {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
  SKYQUILT_TRY(db->Change(
      "INSERT INTO upload(id,flight_id,name,metadata,length,byte_offset,expires_us,owner,concat,parts)"
      " VALUES(?1,?2,?3,?4,?5,?5,?6,?7,?8,?9)",
      joined.id, joined.flight_id, joined.name, joined.metadata, joined.offset, ToUs(joined.expires),
      joined.owner, joined.concat, joined.parts));
  for (const SpooledUpload& part : parts) {
    SKYQUILT_TRY(db->Change("DELETE FROM upload WHERE id=?", part.id));
  }
  return transaction.Commit();
}

Result<SpooledUpload> UploadSpool::Join(const SpooledUpload& wish, const std::vector<std::string>& parts,
                                        bool takes_any, Time now) {
  SKYQUILT_TRY(CheckFileName(wish.name));
  SKYQUILT_TRY_ASSIGN(const bool known, catalogue_.HasFlight(wish.flight_id));
  if (!known) return Error{ErrorCode::kNotFound, "There is no such flight.", ""};
  std::vector<std::string> in_order = parts;
  std::sort(in_order.begin(), in_order.end());
  if (parts.empty() || std::adjacent_find(in_order.begin(), in_order.end()) != in_order.end())
    return Error{ErrorCode::kConflict, "Name each part of the upload once.", ""};
  // All parts stand still meanwhile. Whoever holds several turns takes them in this order.
  std::vector<std::shared_ptr<Turn>> turns;
  std::vector<std::unique_lock<std::mutex>> held;
  for (const std::string& id : in_order) {
    if (!takes_any) {
      const Result<SpooledUpload> part = Read(id, now);
      if (!part && part.error().code != ErrorCode::kNotFound) return part.error();
      if (part && part->owner != wish.owner)
        return Error{ErrorCode::kNotFound, "There is no such part. It may have expired.", ""};
    }
    turns.push_back(TurnOf(id));
    held.emplace_back(turns.back()->mutex);
    SKYQUILT_TRY(TakeOver(*turns.back(), now));
  }
  SKYQUILT_TRY_ASSIGN(std::optional<SpooledUpload> before, JoinedBefore(wish, now));
  if (before && !before->is_done) {
    SKYQUILT_TRY(MakeFile(*before));
  }
  if (before) return *std::move(before);
  SKYQUILT_TRY_ASSIGN(const std::vector<SpooledUpload> complete, CompleteParts(parts, now));
  SpooledUpload joined = wish;
  joined.id = NewId();
  joined.expires = now + kUploadLifetime;
  joined.offset =
      std::accumulate(complete.begin(), complete.end(), std::int64_t{0},
                      [](std::int64_t sum, const SpooledUpload& part) { return sum + part.offset; });
  joined.length = joined.offset;
  if (joined.offset > kMaxFileBytes)
    return Error{ErrorCode::kTooLarge, "The parts together are larger than the server takes.", ""};
  SKYQUILT_TRY(store_.CheckSpace(joined.offset));
  SKYQUILT_TRY(bytes_->Join(complete, joined, [&] { return EnterJoined(joined, complete); }));
  SKYQUILT_TRY(MakeFile(joined));
  return joined;
}

}  // namespace skyquilt::storage
