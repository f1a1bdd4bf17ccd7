// Digest: 128 bits that tell one input from another (XXH3): not against forgery, but against mistaking two
// files or two sets of parameters for each other. Hasher takes values in a fixed order; numbers count by
// their bits. One thread a hasher. Errors of DigestOfFile: kIo.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <type_traits>

#include "core/base/result.h"

namespace skyquilt {

using Digest = std::array<std::uint8_t, 16>;

class Hasher {
 public:
  Hasher();
  ~Hasher();

  Hasher& AddBytes(const void* bytes, std::size_t count);
  // With its length, so that "ab" and "c" are not "a" and "bc".
  Hasher& Add(std::string_view text);
  template <typename Number>
  requires std::is_arithmetic_v<Number> Hasher& Add(Number value) { return AddBytes(&value, sizeof(value)); }
  Digest Finish() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

Result<Digest> DigestOfFile(const std::filesystem::path& path);

}  // namespace skyquilt
