// FolderBlobs: blobs as the files of one folder, each under its key. Any thread. Errors: kNotFound,
// kConflict, kOutOfSpace, kIo.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "storage/blobs/blob_store.h"

namespace skyquilt::storage {

class FolderBlobs final : public BlobStore {
 public:
  explicit FolderBlobs(std::filesystem::path root) : root_(std::move(root)) {}

  Result<void> Put(const std::string& key, const std::filesystem::path& file) override;
  Result<void> PutIfAbsent(const std::string& key, std::string_view bytes) override;
  Result<std::string> ReadRange(const std::string& key, std::int64_t offset, std::int64_t length) override;
  Result<std::string> ReadNear(const std::string& key, std::int64_t offset, std::int64_t length) override {
    return ReadRange(key, offset, length);
  }
  Result<BlobInfo> Find(const std::string& key) override;
  Result<std::vector<BlobInfo>> List(const std::string& prefix) override;
  Result<void> Remove(const std::string& key) override;
  Result<void> Copy(const std::string& from, const std::string& to) override { return Put(to, PathOf(from)); }
  Result<int> RemoveBelow(const std::string& prefix) override;
  Result<LocalBlob> Local(const std::string& key) override;
  bool IsFolder() const override { return true; }
  std::filesystem::path FolderOf(const std::string& prefix) const override { return root_ / prefix; }
  std::string Address() const override { return root_.string(); }

 private:
  std::filesystem::path PathOf(const std::string& key) const;
  std::filesystem::path root_;
};

}  // namespace skyquilt::storage
