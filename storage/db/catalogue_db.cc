#include "storage/db/catalogue_db.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/process/file_descriptor.h"
#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/db/machine_boot.h"
#include "storage/db/postgres/postgres_db.h"
#include "storage/db/schema.h"

namespace skyquilt::storage {
namespace {

constexpr std::chrono::milliseconds kPoll{200};
constexpr std::chrono::milliseconds kListen{2'000};  // nothing is asked of a database
constexpr std::chrono::milliseconds kSoon{50}, kSettled{1'000};

// Tokens' digests and the secrets of webhooks are in it. SQLite gives what it keeps beside a file the file's
// mode.
void KeepFromOthers(const std::filesystem::path& path) {
  // Never one that exists: closing any descriptor of a file lets go of all locks that this process has on it,
  // also those of SQLite's connections. Where it cannot be made, opening the database says why.
  FileDescriptor(open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600)).Close();
  for (const char* ending : {"", "-wal", "-shm"}) {
    // Files of an earlier version were readable by all. Another user's file keeps its mode: then it is that
    // user's care.
    (void)chmod((path.string() + ending).c_str(), 0600);
  }
}

// SQLite cannot tell what may not be opened from what is missing.
Result<void> CheckMayBeUsed(const std::filesystem::path& path) {
  for (const char* ending : {"", "-wal", "-shm"}) {
    const std::string file = path.string() + ending;
    if (access(file.c_str(), R_OK | W_OK) == 0 || errno == ENOENT) continue;
    return Error{ErrorCode::kIo,
                 fmt::format("The file {} cannot be used by this user: {}. Change its owner or mode.", file,
                             std::strerror(errno)),
                 ""};
  }
  return {};
}

Result<bool> IsCatalogue(SqliteDb& db) {
  SKYQUILT_TRY_ASSIGN(
      const std::int64_t tables,
      db.Number(
          "SELECT count(*) FROM sqlite_master WHERE type='table' AND name IN ('flight','file','revision','job')"));
  return tables == 4;
}

// Room to start with, where the disk is full.
void GiveRoom(const std::filesystem::path& path) {
  const SpaceReserve reserve(path);
  if (reserve.IsNeeded()) reserve.Release();
}

// Room to delete with, where it is not.
void KeepRoom(const std::filesystem::path& path) {
  const SpaceReserve reserve(path);
  if (!reserve.IsNeeded()) reserve.Fill();
}

// What is newest goes by ids, also after a start with a clock that was set back.
Result<void> GoOnWithIds(SqlConnection& db) {
  SKYQUILT_TRY_ASSIGN(
      const std::vector<std::string> newest,
      db.AllText("SELECT coalesce(max(id),'') FROM flight UNION ALL SELECT coalesce(max(id),'') FROM job"));
  for (const std::string& id : newest) MakeIdsAfter(id);
  return {};
}

}  // namespace

Result<std::unique_ptr<CatalogueDb>> CatalogueDb::Prepare(SqliteDb db, const std::filesystem::path& path,
                                                          int readers) {
  SKYQUILT_TRY(db.Exec("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"));
  SKYQUILT_TRY(PrepareSchema(db));
  SKYQUILT_TRY(GoOnWithIds(db));
  SKYQUILT_TRY_ASSIGN(const AgeClock ages, AgeClock::Open(db));
  std::unique_ptr<CatalogueDb> catalogue(new CatalogueDb(std::make_unique<SqliteDb>(std::move(db)), ages));
  catalogue->reserve_.emplace(path);
  catalogue->path_ = path;
  for (int i = 0; i < readers; ++i) {
    SKYQUILT_TRY_ASSIGN(SqliteDb reader, SqliteDb::Open(path, OpenMode::kReadShared));
    catalogue->idle_readers_.push_back(std::make_unique<SqliteDb>(std::move(reader)));
  }
  return catalogue;
}

Result<std::unique_ptr<CatalogueDb>> CatalogueDb::Open(const std::filesystem::path& path, int readers) {
  GiveRoom(path);
  KeepRoom(path);
  KeepFromOthers(path);
  SKYQUILT_TRY_ASSIGN(SqliteDb db, SqliteDb::Open(path, OpenMode::kReadWriteCreate));
  return Prepare(std::move(db), path, readers);
}

Result<std::unique_ptr<CatalogueDb>> CatalogueDb::OpenExisting(const std::filesystem::path& path,
                                                               int readers) {
  struct stat status {};
  const Error none{ErrorCode::kNotFound, "There is no catalogue at " + path.string() + ".", ""};
  if (stat(path.c_str(), &status) != 0 || status.st_size == 0) return none;
  if (!S_ISREG(status.st_mode)) return none;
  SKYQUILT_TRY(CheckMayBeUsed(path));
  GiveRoom(path);
  SKYQUILT_TRY_ASSIGN(SqliteDb db, SqliteDb::Open(path, OpenMode::kReadWrite));
  // Before anything is changed in it: it may be another program's.
  SKYQUILT_TRY_ASSIGN(const bool is_ours, IsCatalogue(db));
  if (!is_ours) return none;
  KeepRoom(path);
  KeepFromOthers(path);
  return Prepare(std::move(db), path, readers);
}

Result<std::unique_ptr<CatalogueDb>> CatalogueDb::OpenPostgres(const CataloguePlace& place,
                                                               const std::string& node, bool may_make,
                                                               int readers) {
  const auto silence = std::make_shared<Silence>();
  auto db = std::make_unique<PostgresDb>(place, PostgresDb::Use::kWrite, silence);
  SKYQUILT_TRY(PreparePostgres(*db, place, may_make));
  SKYQUILT_TRY(
      db->Change("INSERT INTO machine VALUES(?1, ?2, now_us()) ON CONFLICT(host) DO UPDATE"
                 " SET boot_id=?2, seen_us=now_us()"
                 " WHERE machine.boot_id<>?2 OR machine.seen_us<now_us()-86400000000",
                 MachineBoot::HostName(), MachineBoot::Id()));
  SKYQUILT_TRY(db->Change("DELETE FROM machine WHERE seen_us<now_us()-30*86400000000"));
  SKYQUILT_TRY(GoOnWithIds(*db));
  SKYQUILT_TRY_ASSIGN(const AgeClock ages, AgeClock::Open(*db));
  std::unique_ptr<CatalogueDb> catalogue(new CatalogueDb(std::move(db), ages));
  catalogue->place_ = place;
  catalogue->silence_ = silence;
  catalogue->served_prefix_ = kServedWorkerPrefix + node + "-";
  catalogue->listener_ = std::make_unique<PostgresDb>(place, PostgresDb::Use::kRead, silence);
  for (int i = 0; i < readers; ++i) {
    catalogue->idle_readers_.push_back(std::make_unique<PostgresDb>(place, PostgresDb::Use::kRead, silence));
  }
  return catalogue;
}

void CatalogueDb::SetPatience(std::chrono::milliseconds time) {
  if (!place_) return;
  static_cast<PostgresDb&>(*Lock()).SetPatience(time);
  const std::lock_guard lock(readers_mutex_);
  for (const auto& reader : idle_readers_) static_cast<PostgresDb&>(*reader).SetPatience(time);
}

Result<void> CatalogueDb::HoldAlone() {
  if (!place_) return {};
  SKYQUILT_TRY_ASSIGN(const bool is_alone, static_cast<PostgresDb&>(*Lock()).HoldAlone());
  if (is_alone) return {};
  return Error{ErrorCode::kConflict,
               "Other servers or workers use the catalogue. Stop all of them, on every machine, and run the "
               "command again. One whose machine died is forgotten within half a minute.",
               ""};
}

bool CatalogueDb::WaitForJobs() {
  if (!place_) return WaitForWrites();
  const Result<bool> heard = static_cast<PostgresDb&>(*listener_).WaitForNotice("jobs", kListen);
  if (!heard) std::this_thread::sleep_for(kPoll);
  return !heard || *heard;
}

// The log is written, then forced to the disk, then shown to others by shared memory, which wakes nobody.
bool CatalogueDb::WaitForWrites() {
  if (!place_ && !events_) {
    events_.emplace();
    events_->Watch({path_.parent_path()});
    return WasWritten();
  }
  if (!events_ || !events_->IsReliable()) {
    std::this_thread::sleep_for(kPoll);
    return WasWritten();
  }
  using Clock = std::chrono::steady_clock;
  if (Clock::now() >= settled_) {
    if (!events_->Wait(kListen)) return false;
    settled_ = Clock::now() + kSettled;
  }
  std::this_thread::sleep_for(kSoon);
  return WasWritten();
}

// SQLite counts for each connection what others have written.
bool CatalogueDb::WasWritten() {
  if (place_) return true;
  const auto version = [&]() -> Result<std::int64_t> {
    if (!listener_) {
      SKYQUILT_TRY_ASSIGN(SqliteDb listener, SqliteDb::Open(path_, OpenMode::kReadShared));
      listener_ = std::make_unique<SqliteDb>(std::move(listener));
    }
    return listener_->Number("PRAGMA data_version");
  }();
  const bool is_news = !version || seen_version_ != *version;
  seen_version_ = version ? std::optional(*version) : std::nullopt;
  return is_news;
}

std::unique_ptr<SqlConnection> CatalogueDb::TakeReader() {
  std::unique_lock lock(readers_mutex_);
  reader_is_back_.wait(lock, [&] { return !idle_readers_.empty(); });
  std::unique_ptr<SqlConnection> reader = std::move(idle_readers_.back());
  idle_readers_.pop_back();
  return reader;
}

void CatalogueDb::GiveBack(std::unique_ptr<SqlConnection> reader) {
  const std::lock_guard lock(readers_mutex_);
  idle_readers_.push_back(std::move(reader));
  reader_is_back_.notify_one();
}

}  // namespace skyquilt::storage
