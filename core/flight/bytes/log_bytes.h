// The bytes of a log as the parsers of this folder see them, and the numbers in them. Any thread.
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string_view>

namespace skyquilt::flight {

using LogBytes = std::span<const std::uint8_t>;

// Parsers say now and then that they will not look again at bytes before `offset`, so that a mapped file may
// give its pages back. A parser that reads twice starts again at 0. May be empty.
using ConsumedUpTo = std::function<void(std::size_t offset)>;

// Says so every 16 MiB of a pass over a file.
class ConsumedSteps {
 public:
  explicit ConsumedSteps(const ConsumedUpTo& consumed) : consumed_(consumed) {}
  void At(std::size_t offset) {
    if (!consumed_ || offset < next_) return;
    consumed_(offset);
    next_ = offset + kStep;
  }

 private:
  static constexpr std::size_t kStep = std::size_t{16} << 20;
  const ConsumedUpTo& consumed_;
  std::size_t next_ = kStep;
};

inline std::string_view TextOf(LogBytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline LogBytes BytesOf(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// The caller has checked that sizeof(T) bytes are there. The machines we build for are little-endian.
template <typename T>
T LoadLittle(const std::uint8_t* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

// The same as a double, for tables of the types of a format.
template <typename T>
double NumberAt(const std::uint8_t* from) {
  return static_cast<double>(LoadLittle<T>(from));
}

// Of `size` bytes from `p`, 8 at most, in either byte order.
inline std::uint64_t UnsignedAt(const std::uint8_t* p, std::size_t size, bool is_big_endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = (value << 8) | p[is_big_endian ? i : size - 1 - i];
  return value;
}

inline std::uint32_t BigEndian32(const std::uint8_t* p) {
  return static_cast<std::uint32_t>(UnsignedAt(p, 4, true));
}

}  // namespace skyquilt::flight
