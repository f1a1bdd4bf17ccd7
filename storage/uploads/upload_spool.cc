#include "storage/uploads/upload_spool.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <set>
#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

// How much may be lost to a power cut without a word to the client; also what a slow disk syncs at a time.
constexpr std::int64_t kSyncEveryBytes = std::int64_t{16} << 20;

constexpr const char* kUploadColumns =
    "SELECT id, flight_id, name, metadata, length, byte_offset, is_done, expires_us, owner, concat, parts FROM upload ";

// To a flight in the trash nothing is added; when it comes back, its uploads do.
constexpr const char* kUploadOfFlightThere =
    "(flight_id IS NULL OR flight_id IN (SELECT id FROM flight WHERE deleted_us IS NULL))";

Error TakenOver() { return {ErrorCode::kConflict, "Another request goes on with this upload.", ""}; }

SpooledUpload UploadFrom(const Statement& row) {
  SpooledUpload upload;
  row.Into(upload.id, upload.flight_id, upload.name, upload.metadata, upload.length, upload.offset,
           upload.is_done, upload.expires, upload.owner, upload.concat, upload.parts);
  return upload;
}

}  // namespace

Error NoSuchUpload() { return {ErrorCode::kNotFound, "There is no such upload. It may have expired.", ""}; }

Error UploadWriteError(const std::string& what) {
  const int code = errno;
  const bool is_full = IsNoRoom(code);
  return {is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo,
          is_full ? "The server's disk is full. Free some space and go on with the upload."
                  : "The server could not store the upload.",
          what + ": " + std::strerror(code)};
}

std::shared_ptr<UploadSpool::Turn> UploadSpool::TurnOf(const std::string& id) {
  const std::lock_guard lock(mutex_);
  std::erase_if(turns_, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<Turn>& known = turns_[id];
  std::shared_ptr<Turn> turn = known.lock();
  if (turn == nullptr) known = turn = std::make_shared<Turn>();
  return turn;
}

Result<SpooledUpload> UploadSpool::Read(const std::string& id, Time now) const {
  if (!IsId(id)) return NoSuchUpload();
  const auto db = db_.Read();
  return db->One(UploadFrom, NoSuchUpload(),
                 std::string(kUploadColumns) + "WHERE id=? AND expires_us>? AND " + kUploadOfFlightThere, id,
                 ToUs(now));
}

Result<SpooledUpload> UploadSpool::Create(const SpooledUpload& wish, Time now) {
  SKYQUILT_TRY(store_.CheckSpace(wish.length.value_or(0)));
  if (!wish.IsPart()) {
    SKYQUILT_TRY(CheckFileName(wish.name));
    SKYQUILT_TRY_ASSIGN(const bool known, catalogue_.HasFlight(wish.flight_id));
    if (!known) return Error{ErrorCode::kNotFound, "There is no such flight.", ""};
  }
  SpooledUpload upload = wish;
  upload.id = NewId();
  upload.expires = now + kUploadLifetime;
  SKYQUILT_TRY(bytes_->Create(upload.id));
  const auto db = db_.Lock();
  const Result<void> inserted = db->Change(
      "INSERT INTO upload(id,flight_id,name,metadata,length,expires_us,owner,concat)"
      " VALUES(?,nullif(?,''),?,?,?,?,?,?)",
      upload.id, upload.flight_id, upload.name, upload.metadata, upload.length, ToUs(upload.expires),
      upload.owner, upload.concat);
  if (!inserted) {
    bytes_->Remove(upload);
    return inserted.error();
  }
  return upload;
}

Result<void> UploadSpool::CheckOwner(const std::string& id, const std::string& requester, Time now) const {
  SKYQUILT_TRY_ASSIGN(const SpooledUpload upload, Read(id, now));
  if (upload.owner != requester) return NoSuchUpload();
  return {};
}

Result<SpooledUpload> UploadSpool::Find(const std::string& id, Time now) {
  const std::shared_ptr<Turn> turn = TurnOf(id);
  const std::lock_guard lock(turn->mutex);
  SKYQUILT_TRY(TakeOver(*turn, now));
  Result<SpooledUpload> upload = Read(id, now);
  if (!upload || upload->is_done || upload->IsPart() || upload->offset != upload->length) return upload;
  // Complete, but its server died before it became a file.
  SKYQUILT_TRY(MakeFile(*upload));
  return upload;
}

Result<std::unique_ptr<UploadSpool::Append>> UploadSpool::Begin(const std::string& id, std::int64_t offset,
                                                                bool all_or_nothing, Time now) {
  const std::shared_ptr<Turn> turn = TurnOf(id);
  const std::lock_guard lock(turn->mutex);
  SKYQUILT_TRY(TakeOver(*turn, now));
  SKYQUILT_TRY_ASSIGN(SpooledUpload upload, Read(id, now));
  if (upload.offset != offset)
    return Error{ErrorCode::kConflict,
                 fmt::format("The upload is at offset {}, not {}.", upload.offset, offset), ""};
  auto file = std::make_unique<IncomingFile>(FileDescriptor());  // what is done takes no more bytes
  if (!upload.is_done) {
    SKYQUILT_TRY_ASSIGN(file, bytes_->Open(upload));
  }
  std::unique_ptr<Append> append(new Append(*this, turn, std::move(upload), std::move(file), all_or_nothing));
  turn->writer = append.get();
  return append;
}

Result<void> UploadSpool::DeclareLength(const std::string& id, std::int64_t length, Time now) {
  SKYQUILT_TRY_ASSIGN(const SpooledUpload upload, Read(id, now));
  if (upload.length == length) return {};
  if (upload.length) return Error{ErrorCode::kConflict, "The upload's length is known and is another.", ""};
  if (length > kMaxFileBytes || length < upload.offset) {
    return Error{ErrorCode::kTooLarge, "The length is beyond what the server takes, or less than what came.",
                 ""};
  }
  SKYQUILT_TRY(store_.CheckSpace(length - upload.offset));
  const auto db = db_.Lock();
  return db->Change("UPDATE upload SET length=?2 WHERE id=?1 AND length IS NULL", id, length);
}

// The bytes in the flight's folder, then one transaction, then the bytes of the upload go: a crash in between
// leaves either the complete upload or the file, and garbage that the sweep removes.
Result<void> UploadSpool::MakeFile(SpooledUpload& upload) const {
  if (upload.offset == 0)
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailFileEmpty);
  SKYQUILT_TRY_ASSIGN(const std::string stored, bytes_->PutInFlight(upload));
  const Result<StoredFile> added = catalogue_.AddFileUnderFreeName(
      upload.flight_id, {upload.name, stored, upload.offset}, Now(), upload.id);
  if (!added) {
    bytes_->TakeBack(upload, stored, added.error());
    return added.error();
  }
  bytes_->Remove(upload);
  upload.is_done = true;
  upload.file = *added;
  return {};
}

Result<void> UploadSpool::Remove(const std::string& id, Time now) {
  const std::shared_ptr<Turn> turn = TurnOf(id);
  const std::lock_guard lock(turn->mutex);
  SKYQUILT_TRY(TakeOver(*turn, now));
  SKYQUILT_TRY_ASSIGN(const SpooledUpload upload, Read(id, now));
  {
    const auto db = db_.Lock();
    SKYQUILT_TRY(db->Change("DELETE FROM upload WHERE id=?", id));
  }
  bytes_->Remove(upload);
  return {};
}

Result<std::vector<SpooledUpload>> UploadSpool::FinishComplete(Time now) {
  std::vector<SpooledUpload> complete;
  {
    const auto db = db_.Read();
    SKYQUILT_TRY_ASSIGN(
        complete,
        db->All(UploadFrom,
                std::string(kUploadColumns) +
                    "WHERE flight_id IS NOT NULL AND is_done=0 AND byte_offset=length AND expires_us>? AND " +
                    kUploadOfFlightThere,
                ToUs(now)));
  }
  // One that cannot be finished stays as it is: its owner's next look tells why.
  std::erase_if(complete, [&](SpooledUpload& upload) { return !MakeFile(upload); });
  return complete;
}

Result<std::vector<fs::path>> UploadSpool::StrayFiles() const {
  std::set<std::string> known;
  {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Statement query, db->Query("SELECT id FROM upload"));
    SKYQUILT_TRY(query.Each([&](const Statement& row) { known.emplace(row.ColumnText(0)); }));
  }
  std::vector<fs::path> stray;
  std::error_code missing;  // a folder that is not there has none
  for (const auto& entry : fs::directory_iterator(store_.dir().Uploads(), missing)) {
    if (!known.contains(entry.path().filename().string())) stray.push_back(entry.path());
  }
  return stray;
}

Result<void> UploadSpool::TakeOver(Turn& turn, Time now) {
  Append* const writer = std::exchange(turn.writer, nullptr);
  if (writer == nullptr || writer->all_or_nothing_) return {};
  return writer->Sync(now);
}

UploadSpool::Append::Append(UploadSpool& spool, std::shared_ptr<Turn> turn, SpooledUpload upload,
                            std::unique_ptr<IncomingFile> file, bool all_or_nothing)
    : spool_(spool),
      turn_(std::move(turn)),
      upload_(std::move(upload)),
      written_(upload_.offset),
      file_(std::move(file)),
      all_or_nothing_(all_or_nothing) {}

UploadSpool::Append::~Append() {
  const std::lock_guard lock(turn_->mutex);
  // Kept if it can be; if not, the client sends these bytes again.
  if (turn_->writer == this) (void)UploadSpool::TakeOver(*turn_, spool_.db_.ages().Now()).ok();
}

Result<void> UploadSpool::Append::Sync(Time now) {
  if (written_ == upload_.offset) return {};
  return spool_.bytes_->Sync(*file_, upload_, written_, now);
}

std::int64_t UploadSpool::Append::saved_offset() const {
  const std::lock_guard lock(turn_->mutex);  // whoever takes over saves what was written
  return upload_.offset;
}

Result<void> UploadSpool::Append::Write(std::span<const std::uint8_t> bytes) {
  const std::lock_guard lock(turn_->mutex);
  if (turn_->writer != this) return TakenOver();
  const auto size = static_cast<std::int64_t>(bytes.size());
  if (size > upload_.length.value_or(kMaxFileBytes) - written_) {
    return Error{ErrorCode::kTooLarge, "More bytes came than the upload's length says.", ""};
  }
  if (!file_->Write(bytes, written_)) return UploadWriteError("write " + upload_.id);
  if (!all_or_nothing_ && written_ - upload_.offset >= kSyncEveryBytes) return Sync(spool_.db_.ages().Now());
  return {};
}

Result<SpooledUpload> UploadSpool::Append::Commit(Time now) {
  const std::lock_guard lock(turn_->mutex);
  if (turn_->writer != this) return TakenOver();
  SKYQUILT_TRY(Sync(now));
  if (!upload_.is_done && !upload_.IsPart() && upload_.offset == upload_.length) {
    SKYQUILT_TRY(spool_.MakeFile(upload_));
  }
  return upload_;
}

}  // namespace skyquilt::storage
