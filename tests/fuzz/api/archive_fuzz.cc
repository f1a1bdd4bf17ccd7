// Any bytes as an archive: files come out or a reason, and never more than the limits say.
#include <unistd.h>

#include <cstdint>
#include <fstream>

#include "core/base/check.h"
#include "storage/db/ids.h"
#include "storage/uploads/unpack_archive.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  static const std::filesystem::path folder = [] {
    std::string name = (std::filesystem::temp_directory_path() / "skyquilt_fuzz_XXXXXX").string();
    SKYQUILT_CHECK(mkdtemp(name.data()) != nullptr, "no folder to work in");
    return std::filesystem::path(name);
  }();
  static const storage::PhotoStore store(*storage::DataDir::Open(folder));
  static const std::string flight = storage::NewId();
  const std::filesystem::path path = folder / "archive";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  storage::ArchiveLimits limits;
  limits.entries = 50;
  limits.file_bytes = 1 << 20;
  limits.total_bytes = 2 << 20;
  const auto files = storage::UnpackArchive(store, flight, path, limits);
  std::int64_t total = 0;
  if (files) {
    SKYQUILT_CHECK(static_cast<int>(files->size()) <= limits.entries, "more entries than the limit");
    for (const storage::UnpackedFile& file : *files) {
      SKYQUILT_CHECK(file.error || storage::CheckFileName(file.file.name).ok(), "a name that is a path");
      total += file.error ? 0 : file.file.bytes;
      if (!file.error) store.Remove(flight, file.file.stored_name);
    }
  }
  SKYQUILT_CHECK(total <= limits.total_bytes, "more bytes than the limit");
  const auto left = folder / "flights" / flight / "files";
  SKYQUILT_CHECK(!std::filesystem::exists(left) || std::filesystem::is_empty(left),
                 "a refused archive left files");
  SKYQUILT_CHECK(std::filesystem::is_empty(folder / "incoming"), "unfinished files are left");
  return 0;
}
