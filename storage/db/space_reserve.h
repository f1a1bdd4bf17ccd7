// SpaceReserve: disk space reserved for deleting. A deletion has to write to the catalogue; on a full disk it
// could not, and no space would ever become free. The reserve is an empty file beside the catalogue; it is
// released when a deletion finds no room, and restored when there is enough. Any thread and process. Nothing
// here fails: without a reserve a full disk refuses deletions, as it would anyway.
#pragma once

#include <filesystem>

namespace skyquilt::storage {

class SpaceReserve {
 public:
  // Of the database `path`.
  explicit SpaceReserve(const std::filesystem::path& path) : path_(path.string() + "-reserve") {}
  // Made whole where the disk has room for it and as much again.
  void Fill() const;
  // False: there was none to give.
  bool Release() const;
  // Whether the disk is so full that even a start needs the reserve.
  bool IsNeeded() const;

 private:
  std::filesystem::path path_;
};

}  // namespace skyquilt::storage
