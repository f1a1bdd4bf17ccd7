#include "storage/folder/data_dir_watch.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

namespace skyquilt::storage {

Result<DataDirWatch> DataDirWatch::Begin(const DataDir& dir, bool has_catalogue) {
  DataDirWatch watch;
  const std::filesystem::path wal = dir.Catalogue().string() + "-wal";
  std::vector<std::pair<std::filesystem::path, const char*>> paths = {
      {dir.root(), "data folder"}, {dir.Flights(), "folder of flights in the data folder"}};
  if (has_catalogue) {
    paths.emplace_back(dir.Catalogue(), "catalogue in the data folder");
    // Holds the latest changes for as long as the catalogue is open.
    paths.emplace_back(wal, "catalogue's log (catalogue.db-wal) in the data folder");
  }
  for (const auto& [path, what] : paths) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0) {
      return Error{ErrorCode::kIo,
                   fmt::format("{} cannot be looked at: {}.", path.string(), std::strerror(errno)), ""};
    }
    watch.watched_.push_back({path, status.st_dev, status.st_ino, what});
  }
  return watch;
}

Result<void> DataDirWatch::Check() const {
  for (const Watched& each : watched_) {
    struct stat status {};
    const bool is_there = stat(each.path.c_str(), &status) == 0;
    if (is_there && status.st_dev == each.device && status.st_ino == each.inode) continue;
    return Error{
        ErrorCode::kUnavailable,
        fmt::format(
            "The server's {} is {}, so that nothing can be stored. It goes on when the folder is back; "
            "otherwise its operator must restart it.",
            each.what, is_there ? "another one than it was" : "gone"),
        each.path.string()};
  }
  return {};
}

}  // namespace skyquilt::storage
