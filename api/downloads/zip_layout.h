// ZipLayout: a zip archive of stored (not compressed) entries as a plan: where every byte of it comes from,
// before any byte is sent. The archive therefore has a length, an entity tag and byte ranges like any file,
// and is never written to disk. Its entries are compressed formats already. Zip64 where a size requires it.
// APPNOTE 6.3.10. Immutable once made.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/http/http_message.h"
#include "core/base/result.h"
#include "storage/exports/streamed/streamed_maps.h"

namespace skyquilt::api {

struct ZipEntry {
  std::string name;                               // "folder/file.ext" in the archive
  std::string bytes;                              // its content, or
  std::filesystem::path path;                     // the file with its content, when not empty, or
  std::optional<storage::OpenStreamed> streamed;  // a file that is nowhere on the disk
};

struct ZipPiece {
  std::string bytes;           // headers and small entries
  std::filesystem::path path;  // or a whole file
  std::optional<storage::OpenStreamed> streamed;
  std::uint64_t offset = 0;  // in the archive
  std::uint64_t length = 0;
};

struct ZipLayout {
  std::vector<ZipPiece> pieces;  // without gaps, in order
  std::uint64_t length = 0;
};

// Reads every file once for its checksum; those of unchanged files are remembered. Errors: kNotFound, kIo,
// those of streamed files.
Result<ZipLayout> PlanZip(const std::vector<ZipEntry>& entries);

// A strong entity tag: of the directory at the end, which has every name, size and checksum.
std::string ZipEtag(const ZipLayout& layout);

// A part of the archive as a body. Its files are open before the first byte, so that they may be unlinked
// meanwhile. Errors: kNotFound, kIo.
Result<std::unique_ptr<BodySource>> ReadZip(std::shared_ptr<const ZipLayout> layout, std::uint64_t offset,
                                            std::uint64_t length);

}  // namespace skyquilt::api
