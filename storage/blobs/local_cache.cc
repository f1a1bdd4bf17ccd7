#include "storage/blobs/local_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <vector>

#include "core/base/process/file_descriptor.h"
#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFetching = ".fetching";
// A fetch that wrote nothing for so long was killed.
constexpr std::chrono::hours kStale{2};
// How exactly the order of use is known: a file is marked as used once in this time.
constexpr std::int64_t kUsedEveryS = 30;

bool IsSameFolder(int fd, const fs::path& folder) {
  struct stat held {
  }, named{};
  return fstat(fd, &held) == 0 && stat(folder.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
         held.st_dev == named.st_dev;
}

Result<std::shared_ptr<const void>> LockFolder(const fs::path& folder) {
  // Whoever shrinks the cache may remove an empty folder between its making and the lock.
  constexpr int kTries = 100;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error == std::errc::no_such_file_or_directory) continue;  // the one above it went meanwhile
    if (error) return FileError("cannot make", folder, error.value());
    const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0 && errno == ENOENT) continue;
    if (fd < 0) return FileError("cannot open", folder, errno);
    int failed = 0;
    do {
      failed = flock(fd, LOCK_SH);
    } while (failed != 0 && errno == EINTR);
    // A shared lock on a folder says: files in it are in use.
    auto in_use = std::make_shared<const FileDescriptor>(fd);
    if (failed != 0) return FileError("cannot lock", folder, errno);
    if (IsSameFolder(fd, folder)) return std::shared_ptr<const void>(std::move(in_use));
  }
  return Error{ErrorCode::kIo, "A folder of the cache is removed again and again.", folder.string()};
}

struct Kept {
  fs::path path;
  std::int64_t bytes;
  std::int64_t used_ns;
};

std::vector<Kept> Survey(const fs::path& root) {
  std::vector<Kept> files;
  std::error_code gone;  // what another process removes meanwhile
  for (auto entry = fs::recursive_directory_iterator(root, gone);
       !gone && entry != fs::recursive_directory_iterator(); entry.increment(gone)) {
    struct stat status {};
    if (entry.depth() == 0 && entry->path().filename() == kFetching) {
      entry.disable_recursion_pending();
    } else if (lstat(entry->path().c_str(), &status) == 0 && S_ISREG(status.st_mode)) {
      const std::int64_t used_ns =
          std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
      files.push_back({entry->path(), std::int64_t{status.st_blocks} * 512, used_ns});
    }
  }
  return files;
}

void RemoveStaleFetches(const fs::path& folder) {
  std::error_code gone;  // another process may do the same
  for (const auto& entry : fs::directory_iterator(folder, gone)) {
    const auto changed = entry.last_write_time(gone);
    if (!gone && changed < fs::file_time_type::clock::now() - kStale) fs::remove(entry.path(), gone);
  }
}

// Does it in a folder that nobody uses; false else.
template <typename Act>
bool InUnusedFolder(const fs::path& folder, Act act) {
  const FileDescriptor fd(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return fd.is_open() && flock(fd.get(), LOCK_EX | LOCK_NB) == 0 && act();
}

// A folder that somebody uses, or that has others in it, stays.
void RemoveEmpty(const fs::path& folder) {
  if (InUnusedFolder(folder, [&] { return rmdir(folder.c_str()) == 0; })) rmdir(folder.parent_path().c_str());
}

// True: it is gone. Not where its folder is in use.
bool RemoveUnused(const fs::path& path) {
  const bool is_gone = InUnusedFolder(path.parent_path(), [&] { return unlink(path.c_str()) == 0; });
  if (is_gone) RemoveEmpty(path.parent_path());
  return is_gone;
}

void MarkUsed(const fs::path& path, const struct stat& status) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (now.tv_sec - status.st_mtim.tv_sec >= kUsedEveryS) utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
}

}  // namespace

Result<std::unique_ptr<LocalCache>> LocalCache::Open(const fs::path& root, std::int64_t budget_bytes) {
  for (const fs::path& folder : {root, root / kFetching}) {
    if (mkdir(folder.c_str(), 0750) != 0 && errno != EEXIST) return FileError("cannot make", folder, errno);
  }
  RemoveStaleFetches(root / kFetching);
  std::unique_ptr<LocalCache> cache(new LocalCache(root, budget_bytes));
  cache->known_bytes_ = cache->Shrink();
  return cache;
}

Result<LocalBlob> LocalCache::Find(const std::string& key) { return Take(key, nullptr); }

Result<LocalBlob> LocalCache::Get(const std::string& key, const Fetch& fetch) { return Take(key, &fetch); }

Result<LocalBlob> LocalCache::Take(const std::string& key, const Fetch* fetch) {
  RequireKey(key);
  const fs::path path = root_ / key;
  struct stat status {};
  if (fetch == nullptr && stat(path.c_str(), &status) != 0)
    return Error{ErrorCode::kNotFound, "The cache has no such file.", key};
  SKYQUILT_TRY_ASSIGN(std::shared_ptr<const void> in_use, Use(path.parent_path()));
  const auto here = [&] {
    if (stat(path.c_str(), &status) != 0) return false;
    MarkUsed(path, status);
    return true;
  };
  if (here()) return LocalBlob{path, std::move(in_use)};
  if (fetch == nullptr) return Error{ErrorCode::kNotFound, "The cache has no such file.", key};
  std::shared_ptr<std::mutex> turn;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(under_way_, [](const auto& entry) { return entry.second.expired(); });
    std::weak_ptr<std::mutex>& known = under_way_[key];
    turn = known.lock();
    if (turn == nullptr) known = turn = std::make_shared<std::mutex>();
  }
  const std::lock_guard lock(*turn);
  if (here()) return LocalBlob{path, std::move(in_use)};
  const fs::path temporary = root_ / kFetching / NewId();
  const Result<void> fetched = (*fetch)(temporary);
  if (!fetched) {
    unlink(temporary.c_str());
    return fetched.error();
  }
  if (rename(temporary.c_str(), path.c_str()) != 0) {
    const int code = errno;
    unlink(temporary.c_str());
    return FileError("cannot keep", path, code);
  }
  if (stat(path.c_str(), &status) == 0) Account(std::int64_t{status.st_blocks} * 512);
  return LocalBlob{path, std::move(in_use)};
}

// One lock for all that use a folder here: a job has thousands of files in one.
Result<std::shared_ptr<const void>> LocalCache::Use(const fs::path& folder) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = in_use_.find(folder.string());
    if (found != in_use_.end()) {
      if (std::shared_ptr<const void> held = found->second.lock()) return held;
    }
  }
  SKYQUILT_TRY_ASSIGN(std::shared_ptr<const void> held, LockFolder(folder));
  const std::lock_guard lock(mutex_);
  std::erase_if(in_use_, [](const auto& entry) { return entry.second.expired(); });
  in_use_[folder.string()] = held;
  return held;
}

void LocalCache::Account(std::int64_t bytes) {
  {
    const std::lock_guard lock(mutex_);
    added_bytes_ += bytes;
    // Others add as well: it is looked at again long before this process alone could have filled it.
    if (known_bytes_ + added_bytes_ <= budget_bytes_ && added_bytes_ <= budget_bytes_ / 8) return;
  }
  const std::unique_lock shrinking(shrinking_, std::try_to_lock);
  if (!shrinking) return;
  const std::int64_t left = Shrink();
  const std::lock_guard lock(mutex_);
  known_bytes_ = left;
  added_bytes_ = 0;
}

// To nine tenths of the budget where it is exceeded; what is left.
std::int64_t LocalCache::Shrink() {
  std::vector<Kept> files = Survey(root_);
  std::int64_t bytes = 0;
  for (const Kept& file : files) bytes += file.bytes;
  if (bytes <= budget_bytes_) return bytes;
  std::sort(files.begin(), files.end(), [](const Kept& a, const Kept& b) { return a.used_ns < b.used_ns; });
  for (const Kept& file : files) {
    if (bytes <= budget_bytes_ - budget_bytes_ / 10) break;
    if (RemoveUnused(file.path)) bytes -= file.bytes;
  }
  return bytes;
}

std::int64_t LocalCache::Measure() const {
  std::int64_t bytes = 0;
  for (const Kept& file : Survey(root_)) bytes += file.bytes;
  return bytes;
}

void LocalCache::Forget(const std::string& key) {
  RequireKey(key);
  unlink((root_ / key).c_str());  // whoever reads it has it open
}

void LocalCache::ForgetBelow(const std::string& prefix) {
  RequireKey(prefix.substr(0, prefix.size() - 1));
  // Also what is in use: whoever reads it has it open, or is late.
  for (const Kept& file : Survey(root_ / prefix)) {
    unlink(file.path.c_str());
    RemoveEmpty(file.path.parent_path());
  }
}

}  // namespace skyquilt::storage
