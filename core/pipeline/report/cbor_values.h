// Bytes, texts, digests and plain values as CBOR has them (RFC 8949), for what processes leave for each
// other. `Cbor` is whichever JSON library's value the including source works with; what is of another kind
// throws its own exceptions. Any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/digest.h"

namespace skyquilt::pipeline {

template <typename Cbor>
Cbor CborOfBytes(const void* data, std::size_t bytes) {
  const auto* first = static_cast<const std::uint8_t*>(data);
  return Cbor::binary(std::vector<std::uint8_t>(first, first + bytes));
}

// Names may be any bytes, which CBOR's text may not.
template <typename Cbor>
Cbor CborOfText(const std::string& text) {
  return CborOfBytes<Cbor>(text.data(), text.size());
}
template <typename Cbor>
std::string TextOfCbor(const Cbor& json) {
  const std::vector<std::uint8_t>& bytes = json.get_binary();
  return {bytes.begin(), bytes.end()};
}

template <typename Cbor>
Cbor CborOfDigest(const Digest& digest) {
  return CborOfBytes<Cbor>(digest.data(), digest.size());
}
// One of another size is that of nothing.
template <typename Cbor>
Digest DigestOfCbor(const Cbor& json) {
  const std::vector<std::uint8_t>& bytes = json.get_binary();
  Digest digest{};
  if (bytes.size() == digest.size()) std::copy(bytes.begin(), bytes.end(), digest.begin());
  return digest;
}

// Plain values as they lie in memory: both sides are the same program on the same kind of machine.
template <typename Cbor, typename Value>
Cbor CborOfValues(const std::vector<Value>& values) {
  static_assert(std::is_trivially_copyable_v<Value>);
  return CborOfBytes<Cbor>(values.data(), values.size() * sizeof(Value));
}
template <typename Value, typename Cbor>
std::vector<Value> ValuesOfCbor(const Cbor& json) {
  static_assert(std::is_trivially_copyable_v<Value>);
  const std::vector<std::uint8_t>& bytes = json.get_binary();
  if (bytes.size() % sizeof(Value) != 0)
    throw Cbor::other_error::create(500, "a list ends in the middle of a value", nullptr);
  std::vector<Value> values(bytes.size() / sizeof(Value));
  if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

}  // namespace skyquilt::pipeline
