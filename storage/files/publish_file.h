// Publishing a finished file: bytes on the disk first, then the name, then the folder. Any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt::storage {

// What the system said of a file, as an Error: kOutOfSpace where the disk is full, else kIo.
Error FileError(const std::string& what, const std::filesystem::path& path, int number);

// What was made, renamed or removed in a folder stays so through a power cut. Errors: kIo, kOutOfSpace.
Result<void> SyncFolder(const std::filesystem::path& folder);

// fsync(temporary), rename to `path`, fsync of the folder. Errors: kIo, kOutOfSpace.
Result<void> PublishFile(const std::filesystem::path& temporary, const std::filesystem::path& path);
// Writes `bytes` under a temporary name and publishes it.
Result<void> WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);
// Of a file written so. Errors: kNotFound, kIo.
Result<std::string> ReadWholeFile(const std::filesystem::path& path);
// Fewer bytes only at its end; never through a link. Errors: kNotFound, kIo.
Result<std::string> ReadRangeOfFile(const std::filesystem::path& path, std::int64_t offset,
                                    std::int64_t length);

}  // namespace skyquilt::storage
