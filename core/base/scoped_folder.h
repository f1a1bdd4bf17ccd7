// ScopedFolder: a folder that goes with the scope and all that is in it, unless it is kept. What cannot be
// removed stays: whoever sweeps temporary names takes it later. Does not make the folder. One owner.
#pragma once

#include <filesystem>
#include <system_error>
#include <utility>

namespace skyquilt {

class ScopedFolder {
 public:
  explicit ScopedFolder(std::filesystem::path path) : path_(std::move(path)) {}
  ~ScopedFolder() {
    if (is_kept_) return;
    std::error_code stays;
    std::filesystem::remove_all(path_, stays);
  }
  ScopedFolder(const ScopedFolder&) = delete;
  ScopedFolder& operator=(const ScopedFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  void Keep() { is_kept_ = true; }

 private:
  std::filesystem::path path_;
  bool is_kept_ = false;
};

}  // namespace skyquilt
