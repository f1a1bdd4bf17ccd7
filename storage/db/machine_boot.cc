#include "storage/db/machine_boot.h"

#include <time.h>
#include <unistd.h>

#include <array>
#include <fstream>

#include "core/base/check.h"
#include "core/base/text/plain_text.h"
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

const std::string& MachineBoot::HostName() {
  static const std::string name = [] {
    std::array<char, 256> text{};
    if (gethostname(text.data(), text.size() - 1) != 0) return std::string("unknown");
    std::string host(text.data());
    for (char& c : host) {
      if (!IsLetterOrDigit(c) && c != '.') c = '_';
    }
    return host.empty() ? std::string("unknown") : host;
  }();
  return name;
}

}  // namespace skyquilt::storage
