// DataDir: where everything of one Skyquilt installation lies on disk. Only this file knows the names:
//   catalogue.db                    flights, files, revisions, jobs
//   flights/<id>/files/<ours>       uploaded bytes, under names we made
//   flights/<id>/r<revision>/       a finished map: mosaic.mbtiles, mosaic.tif, report.json, photos.geojson
//   uploads/                        resumable uploads that are not complete
//   incoming/                       uploads on their way in
//   work/                           jobs on their way, and what is being deleted
// Everything below incoming/ and work/ is garbage after a crash. A value; any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace skyquilt::storage {

class DataDir {
 public:
  // Makes the folders that are missing. Errors: kIo, kOutOfSpace.
  static Result<DataDir> Open(const std::filesystem::path& root);

  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path Catalogue() const { return root_ / "catalogue.db"; }
  std::filesystem::path Flights() const { return root_ / "flights"; }
  std::filesystem::path Flight(const std::string& flight_id) const;
  std::filesystem::path Files(const std::string& flight_id) const;
  std::filesystem::path Revision(const std::string& flight_id, std::int64_t revision) const;
  std::filesystem::path Uploads() const { return root_ / "uploads"; }
  std::filesystem::path Incoming() const { return root_ / "incoming"; }
  std::filesystem::path Work() const { return root_ / "work"; }

 private:
  explicit DataDir(std::filesystem::path root) : root_(std::move(root)) {}
  std::filesystem::path root_;
};

// Holds the data folder for one server at a time; let go by the kernel when the process ends, however it
// ends.
class DataDirLock {
 public:
  // kConflict when another server has it.
  static Result<DataDirLock> Take(const DataDir& dir);
  ~DataDirLock();
  DataDirLock(DataDirLock&& other) noexcept;
  DataDirLock& operator=(DataDirLock&&) = delete;
  DataDirLock(const DataDirLock&) = delete;
  DataDirLock& operator=(const DataDirLock&) = delete;

 private:
  explicit DataDirLock(int fd) : fd_(fd) {}
  int fd_;
};

// Names a revision folder, "r7".
std::string RevisionFolderName(std::int64_t revision);

}  // namespace skyquilt::storage
