// UnpackArchive: the files of a zip or tar (also gzipped) into a flight's store, with hard limits on what an
// archive may make of itself. Names are data: no name is ever a path. Folders are dropped, but for those that
// tell files of one name apart ("101MEDIA_DJI_0001.JPG", core/base/text/file_names.h). All or nothing for
// what is wrong with the archive as a whole; a file inside that cannot be taken is noted and skipped. Any
// thread. Errors: kUnprocessable (damaged, encrypted, beyond a limit), kTooLarge (beyond room_bytes),
// kOutOfSpace, kIo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "storage/uploads/photo_store.h"

namespace skyquilt::storage {

struct ArchiveLimits {
  int entries = 20'000;
  std::int64_t file_bytes = kMaxFileBytes;  // as of a file that comes alone: cards hold films
  std::int64_t total_bytes = std::int64_t{200} << 30;
  // Real photos hardly compress: what grows more than this is made to fill disks. Counted from 1 MiB on.
  std::int64_t growth = 100;
  // What there is room for by other rules than the archive's; kTooLarge beyond.
  std::int64_t room_bytes = std::numeric_limits<std::int64_t>::max();
};

struct UnpackedFile {
  StoredFile file;  // stored_name is empty where `error` says why it was not taken
  std::optional<Error> error;
};

// By the name's end: .zip, .tar, .tar.gz, .tgz.
bool IsArchiveName(std::string_view name);

// Files are in the flight's folder but not yet in the catalogue: the caller adds or removes them.
Result<std::vector<UnpackedFile>> UnpackArchive(const PhotoStore& store, const std::string& flight_id,
                                                const std::filesystem::path& archive,
                                                const ArchiveLimits& limits = {});

}  // namespace skyquilt::storage
