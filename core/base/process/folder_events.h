// FolderEvents: wakes who waits for files in some folders when something happens there (inotify). A hint that
// spares looking again and again, never more: what lies on another machine, what is mounted, and more folders
// than the kernel watches are missed, and IsReliable says so. One thread.
#pragma once

#include <chrono>
#include <filesystem>
#include <vector>

namespace skyquilt {

class FolderEvents {
 public:
  FolderEvents();
  ~FolderEvents();
  FolderEvents(const FolderEvents&) = delete;
  FolderEvents& operator=(const FolderEvents&) = delete;

  // These and no others.
  void Watch(const std::vector<std::filesystem::path>& folders);
  bool IsReliable() const { return is_reliable_; }
  // True: something happened. False: the time is over, or a signal came.
  bool Wait(std::chrono::milliseconds time);

 private:
  void Open();
  int queue_ = -1;
  bool is_reliable_ = false;
  std::vector<std::filesystem::path> folders_;
};

}  // namespace skyquilt
