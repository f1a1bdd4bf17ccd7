#include "storage/packed_half.h"

#include <zlib.h>

#include <new>

namespace skyquilt::storage {
namespace {

// Halves are squares of RGBA of at most this many bytes.
constexpr uLongf kMostHalfBytes = uLongf{2048} * 2048 * 4;

}  // namespace

std::vector<std::uint8_t> PackHalf(const std::vector<std::uint8_t>& bytes) {
  uLongf size = compressBound(bytes.size());
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, bytes.data(), bytes.size(), 1) != Z_OK) throw std::bad_alloc();
  packed.resize(size);
  return packed;
}

Result<std::vector<std::uint8_t>> UnpackHalf(std::span<const std::uint8_t> packed) {
  if (packed.empty()) return std::vector<std::uint8_t>();
  for (uLongf room = uLongf{128} * 128 * 4; room <= kMostHalfBytes; room *= 4) {
    std::vector<std::uint8_t> bytes(room);
    uLongf size = room;
    const int done = uncompress(bytes.data(), &size, packed.data(), packed.size());
    if (done == Z_BUF_ERROR) continue;
    if (done != Z_OK || size != room) break;
    return bytes;
  }
  return Error{ErrorCode::kCorrupt, "the memory of the map is damaged; delete mosaic.state and start again",
               ""};
}

}  // namespace skyquilt::storage
