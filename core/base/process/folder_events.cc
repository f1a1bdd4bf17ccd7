#include "core/base/process/folder_events.h"

#include <linux/magic.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace skyquilt {
namespace {

constexpr std::uint32_t kWhatHappens = IN_CREATE | IN_CLOSE_WRITE | IN_MODIFY | IN_MOVED_TO | IN_MOVED_FROM |
                                       IN_DELETE | IN_DELETE_SELF | IN_MOVE_SELF | IN_UNMOUNT;

// Of file systems that change without this kernel; linux/magic.h lacks some.
constexpr std::array<std::uint32_t, 7> kElsewhere{
    NFS_SUPER_MAGIC,       SMB_SUPER_MAGIC, CIFS_SUPER_MAGIC, 0xFE534D42 /* smb2 */,
    0x65735546 /* fuse */, V9FS_MAGIC,      0x786F4256 /* vboxsf */};

bool LiesElsewhere(const std::filesystem::path& folder) {
  struct statfs status {};
  if (statfs(folder.c_str(), &status) != 0) return true;
  return std::find(kElsewhere.begin(), kElsewhere.end(), static_cast<std::uint32_t>(status.f_type)) !=
         kElsewhere.end();
}

}  // namespace

FolderEvents::FolderEvents() { Open(); }

FolderEvents::~FolderEvents() {
  if (queue_ >= 0) close(queue_);
}

void FolderEvents::Open() {
  if (queue_ >= 0) close(queue_);
  queue_ = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
}

void FolderEvents::Watch(const std::vector<std::filesystem::path>& folders) {
  if (folders == folders_) return;
  // A new queue: it is quick, and a folder that went away and came back is another one of the same name.
  Open();
  folders_ = folders;
  is_reliable_ = queue_ >= 0 && !folders.empty();
  for (const std::filesystem::path& folder : folders) {
    if (queue_ < 0) return;
    const bool is_watched = inotify_add_watch(queue_, folder.c_str(), kWhatHappens | IN_ONLYDIR) >= 0;
    is_reliable_ = is_reliable_ && is_watched && !LiesElsewhere(folder);
  }
}

bool FolderEvents::Wait(std::chrono::milliseconds time) {
  pollfd waited{queue_, POLLIN, 0};  // a queue that is not there is passed over
  const int ready = poll(&waited, 1, static_cast<int>(time.count()));
  if (ready <= 0) return false;
  std::array<char, 1 << 14> events{};
  while (read(queue_, events.data(), events.size()) > 0) {
  }
  return true;
}

}  // namespace skyquilt
