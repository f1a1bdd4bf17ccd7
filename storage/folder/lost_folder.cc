#include "storage/folder/lost_folder.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

std::string Stamp(Time now) { return fmt::format("{:%Y%m%dT%H%M%SZ}", fmt::gmtime(ToUs(now) / 1'000'000)); }

}  // namespace

std::string LostFolder::Take(const fs::path& path, const std::string& why) {
  const fs::path relative = path.lexically_relative(dir_.root());
  const auto stays = [&](const std::string& reason) {
    return fmt::format("{} {}; it could not be moved to lost/ ({}) and stays", relative.string(), why,
                       reason);
  };
  if (mkdir(dir_.Lost().c_str(), 0700) != 0 && errno != EEXIST) return stays(std::strerror(errno));
  // One folder for what comes at one time, unless something of the same path came in the same second.
  constexpr int kMaxTries = 1000;
  fs::path target;
  std::error_code error;
  for (int number = 1; number < kMaxTries; ++number) {
    const fs::path folder =
        dir_.Lost() / (number == 1 ? Stamp(now_) : fmt::format("{}-{}", Stamp(now_), number));
    target = folder / relative;
    if (!fs::exists(fs::symlink_status(target, error))) break;
    target.clear();
  }
  if (target.empty()) return stays("too much of this name is there");
  fs::create_directories(target.parent_path(), error);
  if (error) return stays(error.message());
  if (rename(path.c_str(), target.c_str()) != 0) return stays(std::strerror(errno));
  return fmt::format("{} {}; moved to {}", relative.string(), why,
                     target.lexically_relative(dir_.root()).string());
}

std::vector<LostItem> ListLost(const DataDir& dir) {
  std::vector<LostItem> items;
  std::error_code error;  // a folder that is not there holds nothing
  for (const auto& entry : fs::directory_iterator(dir.Lost(), error)) {
    LostItem item{entry.path(), 0, 0};
    std::error_code unreadable;  // counted as far as it can be read
    if (entry.is_regular_file(unreadable)) {
      item.files = 1;
      item.bytes = static_cast<std::int64_t>(entry.file_size(unreadable));
    }
    if (entry.is_directory(unreadable)) {
      for (auto it = fs::recursive_directory_iterator(
               entry.path(), fs::directory_options::skip_permission_denied, unreadable);
           it != fs::recursive_directory_iterator(); it.increment(unreadable)) {
        if (unreadable) break;
        std::error_code gone;
        if (!it->is_regular_file(gone)) continue;
        ++item.files;
        item.bytes += static_cast<std::int64_t>(it->file_size(gone));
      }
    }
    items.push_back(std::move(item));
  }
  std::sort(items.begin(), items.end(),
            [](const LostItem& a, const LostItem& b) { return a.folder < b.folder; });
  return items;
}

Result<void> PurgeLost(const DataDir& dir) {
  std::error_code error;
  fs::remove_all(dir.Lost(), error);
  if (error) {
    return Error{ErrorCode::kIo,
                 fmt::format("{} could not be removed whole: {}.", dir.Lost().string(), error.message()), ""};
  }
  return {};
}

}  // namespace skyquilt::storage
