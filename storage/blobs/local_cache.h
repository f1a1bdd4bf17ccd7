// LocalCache: files of this machine that were fetched from elsewhere and can be fetched again, each under
// its key, within a budget of bytes: those that were used least recently go. Several processes may use one
// folder. What is fetched gets a temporary name until it is whole. A file is kept while anybody uses another
// of the same folder, as its lock (flock) tells across processes, also those that were killed; then the
// budget is exceeded rather than a file taken away. Any thread. Errors: kOutOfSpace, kIo, and those of
// fetching.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"

namespace skyquilt::storage {

inline constexpr std::int64_t kUsualCacheBytes = std::int64_t{20} << 30;

class LocalCache {
 public:
  // Makes the folder where it is missing, but none above it.
  static Result<std::unique_ptr<LocalCache>> Open(const std::filesystem::path& root,
                                                  std::int64_t budget_bytes);

  using Fetch = std::function<Result<void>(const std::filesystem::path& to)>;
  // Fetched by one thread at a time; the others wait for it.
  Result<LocalBlob> Get(const std::string& key, const Fetch& fetch);
  // Only what is here; kNotFound else.
  Result<LocalBlob> Find(const std::string& key);
  void Forget(const std::string& key);
  void ForgetBelow(const std::string& prefix);

  const std::filesystem::path& root() const { return root_; }
  // What is in it, by looking.
  std::int64_t Measure() const;

 private:
  LocalCache(std::filesystem::path root, std::int64_t budget_bytes)
      : root_(std::move(root)), budget_bytes_(budget_bytes) {}
  Result<LocalBlob> Take(const std::string& key, const Fetch* fetch);
  Result<std::shared_ptr<const void>> Use(const std::filesystem::path& folder);
  void Account(std::int64_t bytes);
  std::int64_t Shrink();

  const std::filesystem::path root_;
  const std::int64_t budget_bytes_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<std::mutex>> under_way_;
  std::map<std::string, std::weak_ptr<const void>> in_use_;
  std::int64_t known_bytes_ = 0;  // when it was last looked at
  std::int64_t added_bytes_ = 0;  // since then, by this process
  std::mutex shrinking_;
};

}  // namespace skyquilt::storage
