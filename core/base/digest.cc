#include "core/base/digest.h"

#include <xxhash.h>

#include <cstring>
#include <fstream>
#include <new>
#include <system_error>
#include <vector>

namespace skyquilt {

struct Hasher::State {
  XXH3_state_t* xxh = nullptr;
};

Hasher::Hasher() : state_(std::make_unique<State>()) {
  state_->xxh = XXH3_createState();
  if (state_->xxh == nullptr) throw std::bad_alloc();
  XXH3_128bits_reset(state_->xxh);
}

Hasher::~Hasher() { XXH3_freeState(state_->xxh); }

Hasher& Hasher::AddBytes(const void* bytes, std::size_t count) {
  XXH3_128bits_update(state_->xxh, bytes, count);
  return *this;
}

Hasher& Hasher::Add(std::string_view text) {
  Add(static_cast<std::uint64_t>(text.size()));
  return AddBytes(text.data(), text.size());
}

Digest Hasher::Finish() const {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_->xxh));
  Digest digest;
  std::memcpy(digest.data(), canonical.digest, digest.size());
  return digest;
}

Result<Digest> DigestOfFile(const std::filesystem::path& path) {
  constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
  // A device gives bytes without end, a pipe none until somebody writes.
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown))
    return Error{ErrorCode::kIo, path.string() + " is not a regular file.", ""};
  std::ifstream file(path, std::ios::binary);
  std::vector<char> chunk(kChunkBytes);
  Hasher hasher;
  while (file.read(chunk.data(), kChunkBytes) || file.gcount() > 0) {
    hasher.AddBytes(chunk.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (!file.eof()) return Error{ErrorCode::kIo, "Cannot read " + path.string() + ".", ""};
  return hasher.Finish();
}

}  // namespace skyquilt
