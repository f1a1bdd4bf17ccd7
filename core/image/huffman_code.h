// HuffmanCode: how deflate (RFC 1951, 3.2.2) writes each symbol, given how often each occurs. A value; any
// thread.
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

}  // namespace skyquilt::image
