// UnpackSandboxed: unpacks an uploaded archive in a process of its own, with limits of memory, CPU time and
// file size, so that a malicious archive harms that process alone. It unpacks into a folder of its own below
// incoming/; only files that were unpacked completely are added to the flight. Blocking; any thread. Errors:
// those of storage::UnpackArchive, kUnprocessable where the process did not finish, and kOutOfSpace or kIo
// where the folder cannot be made.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "storage/uploads/photo_store.h"
#include "storage/uploads/unpack_archive.h"

namespace skyquilt::server {

Result<std::vector<storage::UnpackedFile>> UnpackSandboxed(const storage::PhotoStore& store,
                                                           const std::string& flight_id,
                                                           const std::filesystem::path& archive,
                                                           std::int64_t max_bytes);

// What that process does. The exit code.
int UnpackInSandbox(int parent);

}  // namespace skyquilt::server
