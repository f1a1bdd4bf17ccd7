// UploadSpool::Join: the parts of an upload become one.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <numeric>

#include "core/base/process/file_descriptor.h"
#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/uploads/upload_spool.h"

namespace skyquilt::storage {
namespace {

Error JoinError(const std::filesystem::path& path) {
  const int code = errno;
  const bool is_full = code == ENOSPC || code == EDQUOT;
  return {is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo,
          is_full ? "The server's disk is full. Free some space and ask again for the whole upload."
                  : "The server could not put the parts of the upload together.",
          path.string() + ": " + std::strerror(code)};
}

}  // namespace

Result<std::optional<SpooledUpload>> UploadSpool::JoinedBefore(const SpooledUpload& wish, Time now) const {
  std::string id;
  {
    const auto db = db_.Read();
    SKYQUILT_TRY_ASSIGN(
        Statement query,
        db->Query("SELECT id FROM upload WHERE flight_id=? AND owner=? AND concat=? AND name=?",
                  wish.flight_id, wish.owner, wish.concat, wish.name));
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return std::optional<SpooledUpload>();
    id = query.ColumnText(0);
  }
  SKYQUILT_TRY_ASSIGN(SpooledUpload upload, Read(id, now));
  return std::optional(std::move(upload));
}

Result<std::vector<SpooledUpload>> UploadSpool::CompleteParts(const std::vector<std::string>& parts,
                                                              Time now) const {
  std::vector<SpooledUpload> complete;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    SKYQUILT_TRY_ASSIGN(SpooledUpload part, Read(parts[i], now));
    if (!part.IsPart()) {
      return Error{
          ErrorCode::kConflict,
          fmt::format("The upload {} is not a part: it was begun without Upload-Concat: partial.", parts[i]),
          ""};
    }
    if (part.offset != part.length) {
      return Error{ErrorCode::kConflict,
                   fmt::format("Part {} of {} is not complete: send the rest of its bytes first.", i + 1,
                               parts.size()),
                   ""};
    }
    complete.push_back(std::move(part));
  }
  return complete;
}

Result<void> UploadSpool::CopyParts(const std::vector<SpooledUpload>& parts,
                                    const std::filesystem::path& to) const {
  const FileDescriptor whole(open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0640));
  if (!whole.is_open()) return JoinError(to);
  for (const SpooledUpload& part : parts) {
    const FileDescriptor from(open(PathOf(part.id).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
    if (!from.is_open()) return JoinError(PathOf(part.id));
    // Behind the offset there may be bytes that never were promised.
    for (std::int64_t left = part.offset; left > 0;) {
      const ssize_t copied =
          copy_file_range(from.get(), nullptr, whole.get(), nullptr, static_cast<std::size_t>(left), 0);
      if (copied < 0 && errno == EINTR) continue;
      if (copied < 0) return JoinError(to);
      if (copied == 0)
        return Error{ErrorCode::kIo, "A part of the upload is damaged on the server.", PathOf(part.id)};
      left -= copied;
    }
  }
  if (fdatasync(whole.get()) != 0) return JoinError(to);
  return {};
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
  Result<void> done;
  if (IsInObjectStore()) {
    // Their chunks are its chunks.
    for (const SpooledUpload& part : complete) joined.parts += part.parts;
  } else {
    done = CopyParts(complete, PathOf(joined.id));
  }
  if (done) done = EnterJoined(joined, complete);
  if (!done) {
    unlink(PathOf(joined.id).c_str());
    return done.error();
  }
  for (const SpooledUpload& part : complete) unlink(PathOf(part.id).c_str());
  SKYQUILT_TRY(MakeFile(joined));
  return joined;
}

}  // namespace skyquilt::storage
