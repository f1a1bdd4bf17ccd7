#include "storage/uploads/upload_spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/db/ids.h"

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

Error NoSuchUpload() { return {ErrorCode::kNotFound, "There is no such upload. It may have expired.", ""}; }

Error TakenOver() { return {ErrorCode::kConflict, "Another request goes on with this upload.", ""}; }

SpooledUpload UploadFrom(const Statement& row) {
  SpooledUpload upload;
  upload.id = row.ColumnText(0);
  upload.flight_id = row.ColumnText(1);
  upload.name = row.ColumnText(2);
  upload.metadata = row.ColumnText(3);
  if (!row.IsNull(4)) upload.length = row.ColumnInt64(4);
  upload.offset = row.ColumnInt64(5);
  upload.is_done = row.ColumnInt64(6) != 0;
  upload.expires = FromUs(row.ColumnInt64(7));
  upload.owner = row.ColumnText(8);
  upload.concat = row.ColumnText(9);
  upload.parts = row.ColumnText(10);
  return upload;
}

Error WriteError(const std::string& what) {
  const int code = errno;
  const bool is_full = code == ENOSPC || code == EDQUOT;
  return {is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo,
          is_full ? "The server's disk is full. Free some space and go on with the upload."
                  : "The server could not store the upload.",
          what + ": " + std::strerror(code)};
}

}  // namespace

fs::path UploadSpool::PathOf(const std::string& id) const { return store_.dir().Uploads() / id; }

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
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Query(std::string(kUploadColumns) + "WHERE id=? AND expires_us>? AND " + kUploadOfFlightThere, id,
                ToUs(now)));
  SKYQUILT_TRY_ASSIGN(std::optional<SpooledUpload> upload, query.First(UploadFrom));
  if (!upload) return NoSuchUpload();
  return *std::move(upload);
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
  if (!IsInObjectStore()) {
    const int fd =
        open(PathOf(upload.id).c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0640);
    if (fd < 0) return WriteError("open " + PathOf(upload.id).string());
    close(fd);
  }
  const auto db = db_.Lock();
  const Result<void> inserted = db->Change(
      "INSERT INTO upload(id,flight_id,name,metadata,length,expires_us,owner,concat)"
      " VALUES(?,nullif(?,''),?,?,?,?,?,?)",
      upload.id, upload.flight_id, upload.name, upload.metadata, upload.length, ToUs(upload.expires),
      upload.owner, upload.concat);
  if (!inserted) {
    unlink(PathOf(upload.id).c_str());
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
  if (upload.offset != offset) {
    return Error{ErrorCode::kConflict,
                 fmt::format("The upload is at offset {}, not {}.", upload.offset, offset), ""};
  }
  int fd = -1;
  fs::path temporary;
  if (!upload.is_done && IsInObjectStore()) {
    const DataDir& dir = store_.dir();
    temporary = dir.Incoming() / dir.NewTemporaryName(kUploadKind);
    fd = open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0640);
    if (fd < 0) return WriteError("open " + temporary.string());
  } else if (!upload.is_done) {
    fd = open(PathOf(id).c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC);
    if (fd < 0) return WriteError("open " + PathOf(id).string());
    // Behind the offset there may be bytes that never were promised.
    if (ftruncate(fd, offset) != 0 || lseek(fd, offset, SEEK_SET) < 0) {
      const Error error = WriteError("truncate " + PathOf(id).string());
      close(fd);
      return error;
    }
  }
  std::unique_ptr<Append> append(
      new Append(*this, turn, std::move(upload), fd, all_or_nothing, std::move(temporary)));
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

Result<void> UploadSpool::SaveOffset(const std::string& id, std::int64_t offset, Time now) const {
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Change("UPDATE upload SET byte_offset=?2, expires_us=?3 WHERE id=?1", id, offset,
                          ToUs(now + kUploadLifetime)));
  if (db->Changes() == 0) return NoSuchUpload();
  return {};
}

// A second name for the bytes, then one transaction, then the first name goes: a crash in between leaves
// either the complete upload or the file, and garbage that the sweep removes.
Result<void> UploadSpool::MakeFile(SpooledUpload& upload) const {
  if (upload.offset == 0) {
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailFileEmpty);
  }
  if (IsInObjectStore()) return MakeFileInObjectStore(upload);
  SKYQUILT_TRY_ASSIGN(const std::string stored, store_.Adopt(upload.flight_id, PathOf(upload.id)));
  const Result<StoredFile> added = catalogue_.AddFileUnderFreeName(
      upload.flight_id, {upload.name, stored, upload.offset}, Now(), upload.id);
  if (!added) {
    store_.Remove(upload.flight_id, stored);
    return added.error();
  }
  unlink(PathOf(upload.id).c_str());  // what stays is removed with the expired
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
  RemoveChunks(upload.parts);
  unlink(PathOf(id).c_str());  // what stays is removed with the expired
  return {};
}

Result<std::vector<SpooledUpload>> UploadSpool::FinishComplete(Time now) {
  std::vector<SpooledUpload> complete;
  {
    const auto db = db_.Read();
    SKYQUILT_TRY_ASSIGN(
        Statement query,
        db->Query(
            std::string(kUploadColumns) +
                "WHERE flight_id IS NOT NULL AND is_done=0 AND byte_offset=length AND expires_us>? AND " +
                kUploadOfFlightThere,
            ToUs(now)));
    SKYQUILT_TRY_ASSIGN(complete, query.All(UploadFrom));
  }
  // One that cannot be finished stays as it is: its owner's next look tells why.
  std::erase_if(complete, [&](SpooledUpload& upload) { return !MakeFile(upload); });
  return complete;
}

Result<int> UploadSpool::RemoveExpired(Time now) {
  if (IsInObjectStore()) return RemoveExpiredInObjectStore(now);
  std::vector<std::string> over;
  {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Statement query, db->Query("SELECT id FROM upload WHERE expires_us<=?1", ToUs(now)));
    SKYQUILT_TRY_ASSIGN(over, query.AllText());
  }
  // The bytes first: as long as the row is there, they are known to be nobody's.
  int count = 0;
  for (const std::string& id : over) {
    if (unlink(PathOf(id).c_str()) == 0) ++count;
  }
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Change("DELETE FROM upload WHERE expires_us<=?", ToUs(now)));
  return count;
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

UploadSpool::Append::Append(UploadSpool& spool, std::shared_ptr<Turn> turn, SpooledUpload upload, int fd,
                            bool all_or_nothing, fs::path temporary)
    : spool_(spool),
      turn_(std::move(turn)),
      upload_(std::move(upload)),
      written_(upload_.offset),
      fd_(fd),
      all_or_nothing_(all_or_nothing),
      temporary_(std::move(temporary)) {}

UploadSpool::Append::~Append() {
  {
    const std::lock_guard lock(turn_->mutex);
    // Kept if it can be; if not, the client sends these bytes again.
    if (turn_->writer == this) (void)UploadSpool::TakeOver(*turn_, spool_.db_.ages().Now()).ok();
  }
  if (fd_ >= 0) close(fd_);
  if (!temporary_.empty()) unlink(temporary_.c_str());  // what stays the sweep removes
}

Result<void> UploadSpool::Append::Sync(Time now) {
  if (written_ == upload_.offset) return {};
  if (!temporary_.empty()) return SyncToObjectStore(now);
  if (fdatasync(fd_) != 0) return WriteError("sync " + spool_.PathOf(upload_.id).string());
  SKYQUILT_TRY(spool_.SaveOffset(upload_.id, written_, now));
  upload_.offset = written_;
  upload_.expires = now + kUploadLifetime;
  return {};
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
  while (!bytes.empty()) {
    const ssize_t wrote = write(fd_, bytes.data(), bytes.size());
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) return WriteError("write " + upload_.id);
    written_ += wrote;
    bytes = bytes.subspan(static_cast<std::size_t>(wrote));
  }
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
