#include "storage/db/machine_boot.h"

#include <time.h>

#include <fstream>

#include "core/base/check.h"
#include "storage/db/ids.h"

namespace skyquilt::storage {

const std::string& MachineBoot::Id() {
  static const std::string id = [] {
    std::string text;
    std::ifstream file("/proc/sys/kernel/random/boot_id");
    if (!(file >> text) || text.empty()) text = "process-" + NewId();
    return text;
  }();
  return id;
}

std::chrono::microseconds MachineBoot::Elapsed() {
  timespec time{};
  SKYQUILT_CHECK(clock_gettime(CLOCK_BOOTTIME, &time) == 0, "the kernel has a clock since its start");
  return std::chrono::seconds(time.tv_sec) + std::chrono::microseconds(time.tv_nsec / 1000);
}

}  // namespace skyquilt::storage
