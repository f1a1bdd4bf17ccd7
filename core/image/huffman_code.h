// HuffmanCode: how deflate (RFC 1951, 3.2.2) and WebP write each symbol, given how often each occurs. A
// value; any thread. BitWriter: bits, the first in the lowest place of a byte, as both have them, into room
// that was measured before. One thread.
#pragma once

#include <cstdint>
#include <vector>

namespace skyquilt::image {

struct HuffmanCode {
  // By symbol; length 0: never occurs. Bits are in the order of writing, the first lowest.
  struct Word {
    std::uint16_t bits = 0;
    std::uint8_t length = 0;  // at most 15
  };
  std::vector<Word> words;

  // At least two symbols must occur.
  static HuffmanCode Of(std::vector<std::uint32_t> counts);
};

class BitWriter {
 public:
  explicit BitWriter(std::uint8_t* out) : out_(out) {}
  // At most 32 bits.
  void Put(std::uint64_t bits, int count) {
    held_ |= bits << count_;
    count_ += count;
    if (count_ >= 32) {
      const auto word = static_cast<std::uint32_t>(held_);
      for (int i = 0; i < 4; ++i) *out_++ = static_cast<std::uint8_t>(word >> (8 * i));
      held_ >>= 32;
      count_ -= 32;
    }
  }
  void Put(const HuffmanCode::Word& word) { Put(word.bits, word.length); }
  void Put(const HuffmanCode::Word& first, const HuffmanCode::Word& second) {
    Put(first.bits | std::uint64_t{second.bits} << first.length, first.length + second.length);
  }
  // Where the whole bytes end.
  std::uint8_t* Finish() {
    for (; count_ > 0; count_ -= 8, held_ >>= 8) *out_++ = static_cast<std::uint8_t>(held_);
    return out_;
  }

 private:
  std::uint8_t* out_;
  std::uint64_t held_ = 0;
  int count_ = 0;
};

}  // namespace skyquilt::image
