// UnpackApart: an uploaded archive is unpacked by a process of its own, under limits of memory, CPU time and
// file size, so that one made to harm the unpacker harms that process alone. It unpacks into a folder of its
// own below incoming/; only what came out whole is taken into the flight. Blocking; any thread. Errors: those
// of storage::UnpackArchive, and kUnprocessable where the process did not live to its end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "storage/uploads/photo_store.h"
#include "storage/uploads/unpack_archive.h"

namespace skyquilt::server {

Result<std::vector<storage::UnpackedFile>> UnpackApart(const storage::PhotoStore& store,
                                                       const std::string& flight_id,
                                                       const std::filesystem::path& archive,
                                                       std::int64_t max_bytes);

// What that process does: unpacks `archive` below the data folder `staging` and writes what it found to
// standard output, as UnpackApart reads it.
void UnpackHere(const std::filesystem::path& staging, const std::string& flight_id,
                const std::filesystem::path& archive, std::int64_t max_bytes);

}  // namespace skyquilt::server
