// FarFolder: a folder that stands for S3 in a test: all that differs is that it is not the data folder, and
// that it fails as it is told.
#pragma once

#include <atomic>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "storage/blobs/folder_blobs.h"

namespace skyquilt::test {

class FarFolder final : public storage::BlobStore {
 public:
  explicit FarFolder(const std::filesystem::path& root) : folder_(root) {}
  Result<void> Put(const std::string& key, const std::filesystem::path& file) override {
    if (puts_left-- <= 0) return Error{ErrorCode::kUnavailable, "away", ""};
    SKYQUILT_CHECK(folder_.Put(key, file).ok(), "the test's folder is full");
    if (key == damages) std::ofstream(folder_.FolderOf(key), std::ios::binary | std::ios::in) << "?";
    return {};
  }
  Result<void> PutIfAbsent(const std::string& key, std::string_view bytes) override {
    if (puts_left <= 0) return Error{ErrorCode::kUnavailable, "away", ""};
    return folder_.PutIfAbsent(key, bytes);
  }
  Result<std::string> ReadRange(const std::string& key, std::int64_t offset, std::int64_t length) override {
    return folder_.ReadRange(key, offset, length);
  }
  Result<std::string> ReadNear(const std::string& key, std::int64_t offset, std::int64_t length) override {
    ++near_reads;
    return folder_.ReadNear(key, offset, length);
  }
  Result<storage::BlobInfo> Find(const std::string& key) override { return folder_.Find(key); }
  Result<std::vector<storage::BlobInfo>> List(const std::string& prefix) override {
    if (before_list) before_list(prefix);
    return folder_.List(prefix);
  }
  Result<std::optional<std::string>> KnownSum(const std::string& key) override {
    const auto found = known.find(key);
    return found == known.end() ? std::nullopt : std::optional(found->second);
  }
  Result<void> Remove(const std::string& key) override { return folder_.Remove(key); }
  Result<void> Copy(const std::string& from, const std::string& to) override {
    return folder_.Copy(from, to);
  }
  Result<int> RemoveBelow(const std::string& prefix) override { return folder_.RemoveBelow(prefix); }
  Result<storage::LocalBlob> Local(const std::string& key) override {
    ++fetched;
    return folder_.Local(key);
  }
  bool IsFolder() const override { return false; }
  std::filesystem::path FolderOf(const std::string& prefix) const override {
    return folder_.FolderOf(prefix);
  }
  std::string Address() const override { return "s3://far/"; }

  int puts_left = 1'000;
  std::atomic<int> fetched = 0, near_reads = 0;
  std::string damages;
  std::map<std::string, std::string> known;                    // sums by key
  std::function<void(const std::string& prefix)> before_list;  // it is as slow as this

 private:
  storage::FolderBlobs folder_;
};

}  // namespace skyquilt::test
