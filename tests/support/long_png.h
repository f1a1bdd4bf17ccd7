// LongPng: a black PNG whose compressed rows go on behind the last that its header has, by as many zeros as
// are wanted: what a bomb is, uncompressed so that it is made at once.
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace skyquilt::test {

struct LongPngHeader {
  std::uint32_t width_px = 0, height_px = 0;
  std::uint8_t depth = 8, colour = 2, interlace = 0;
};

// `row_bytes`: of all rows of the header, each with the byte of its filter.
inline std::vector<std::uint8_t> LongPng(const LongPngHeader& header, std::size_t row_bytes,
                                         std::size_t more) {
  std::vector<std::uint8_t> png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  const auto number = [](std::vector<std::uint8_t>& to, std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) to.push_back(static_cast<std::uint8_t>(value >> shift));
  };
  const auto chunk = [&](std::string_view kind, const std::vector<std::uint8_t>& content) {
    number(png, static_cast<std::uint32_t>(content.size()));
    const std::size_t begin = png.size();
    png.insert(png.end(), kind.begin(), kind.end());
    png.insert(png.end(), content.begin(), content.end());
    number(png,
           static_cast<std::uint32_t>(crc32(0, png.data() + begin, static_cast<uInt>(png.size() - begin))));
  };
  std::vector<std::uint8_t> head;
  number(head, header.width_px);
  number(head, header.height_px);
  head.insert(head.end(), {header.depth, header.colour, 0, 0, header.interlace});
  chunk("IHDR", head);
  const std::vector<std::uint8_t> rows(row_bytes + more, 0);
  uLongf size = compressBound(static_cast<uLong>(rows.size()));
  std::vector<std::uint8_t> packed(size);
  compress2(packed.data(), &size, rows.data(), static_cast<uLong>(rows.size()), Z_NO_COMPRESSION);
  packed.resize(size);
  chunk("IDAT", packed);
  chunk("IEND", {});
  return png;
}

}  // namespace skyquilt::test
