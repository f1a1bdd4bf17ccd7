#include "core/image/png_encoder.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <string_view>

#include "core/base/check.h"
#include "core/image/huffman_code.h"
#include "core/image/png_decoder.h"

namespace skyquilt::image {
namespace {

constexpr std::uint8_t kAverageFilter = 3;
constexpr std::size_t kEndOfBlock = 256;
constexpr std::size_t kFirstLength = 257, kLengths = 29;
constexpr std::size_t kSymbols = kFirstLength + kLengths;
constexpr int kLongestMatch = 258;

// How a match's length is written: a symbol and some bits.
struct MatchLength {
  std::uint16_t symbol = 0;
  std::uint8_t extra_bits = 0;
  std::uint16_t extra = 0;
};

// RFC 1951, 3.2.5.
MatchLength LengthOf(int length) {
  if (length == kLongestMatch) return {kFirstLength + kLengths - 1, 0, 0};
  const int over = length - 3;
  if (over < 8) return {static_cast<std::uint16_t>(kFirstLength + over), 0, 0};
  const int extra_bits = std::bit_width(static_cast<unsigned>(over)) - 3;
  return {static_cast<std::uint16_t>(kFirstLength + 4 * static_cast<std::size_t>(extra_bits + 1) +
                                     (over >> extra_bits) - 4),
          static_cast<std::uint8_t>(extra_bits), static_cast<std::uint16_t>(over & ((1 << extra_bits) - 1))};
}

// Every row after its filter byte: what the mean of the pixels to the left and above did not foretell.
std::vector<std::uint8_t> Filtered(const RgbaImage& image, int x, int y, int width_px, int height_px,
                                   bool straightens) {
  const auto row_bytes = static_cast<std::size_t>(width_px) * 4;
  std::vector<std::uint8_t> filtered((row_bytes + 1) * static_cast<std::size_t>(height_px));
  // Four zeros before each row are the pixel to the left of its first.
  std::vector<std::uint8_t> above(row_bytes + 4, 0), row(row_bytes + 4, 0);
  std::uint8_t* out = filtered.data();
  for (int dy = 0; dy < height_px; ++dy) {
    if (straightens) {
      StraightenAlpha(image.Pixel(x, y + dy), width_px, row.data() + 4);
    } else {
      std::memcpy(row.data() + 4, image.Pixel(x, y + dy), row_bytes);
    }
    *out++ = kAverageFilter;
    const std::uint8_t* left = row.data();
    const std::uint8_t* here = row.data() + 4;
    const std::uint8_t* up = above.data() + 4;
    for (std::size_t i = 0; i < row_bytes; ++i)
      out[i] = static_cast<std::uint8_t>(here[i] - ((left[i] + up[i]) >> 1));
    out += row_bytes;
    std::swap(above, row);
  }
  return filtered;
}

// Walks the filtered rows: literal(byte) and as_is(pixel) for what is written as it is, run(n) for n zeros
// that follow a zero.
template <typename Literal, typename AsIs, typename Run>
void Walk(const std::vector<std::uint8_t>& filtered, int width_px, int height_px, const Literal& literal,
          const AsIs& as_is, const Run& run) {
  const std::uint8_t* in = filtered.data();
  for (int y = 0; y < height_px; ++y) {
    literal(*in++);
    for (int x = 0; x < width_px;) {
      std::uint32_t pixel = 0;
      int zeros = 0;
      while (x + zeros < width_px && (std::memcpy(&pixel, in + std::ptrdiff_t{4} * zeros, 4), pixel == 0))
        ++zeros;
      if (zeros > 0) {
        literal(0);
        for (int rest = 4 * zeros - 1; rest > 0;) {
          // Never leaves a rest too short for a match.
          const int taken = rest <= kLongestMatch ? rest : std::min(kLongestMatch, rest - 3);
          run(taken);
          rest -= taken;
        }
      } else {
        as_is(in);
        zeros = 1;
      }
      in += std::ptrdiff_t{4} * zeros;
      x += zeros;
    }
  }
}

// The lengths of the code's words are written four bits each, by a code in which all words have four bits.
void PutCode(const HuffmanCode& code, BitWriter& out) {
  constexpr std::array<int, 19> kOrder{16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
  constexpr int kDistances = 1;  // that of one byte
  out.Put(0b101, 3);             // last block, its own code
  out.Put(kSymbols - kFirstLength, 5);
  out.Put(kDistances - 1, 5);
  out.Put(kOrder.size() - 4, 4);
  for (const int symbol : kOrder) out.Put(symbol < 16 ? 4 : 0, 3);
  const auto put_length = [&](unsigned length) {
    unsigned mirrored = 0;
    for (unsigned bit = 0; bit < 4; ++bit) mirrored |= (length >> bit & 1U) << (3 - bit);
    out.Put(mirrored, 4);
  };
  for (const HuffmanCode::Word& word : code.words) put_length(word.length);
  put_length(1);
}

void PutBigEndian(std::uint32_t value, std::uint8_t* out) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}

// Room for length, name and sum around the chunk's content.
void CloseChunk(std::string_view name, std::uint8_t* chunk, std::size_t size) {
  PutBigEndian(static_cast<std::uint32_t>(size), chunk);
  std::memcpy(chunk + 4, name.data(), 4);
  PutBigEndian(libdeflate_crc32(0, chunk + 4, size + 4), chunk + 8 + size);
}

std::vector<std::uint8_t> EncodePart(const RgbaImage& image, int x, int y, int width_px, int height_px,
                                     bool straightens) {
  SKYQUILT_CHECK(width_px > 0 && height_px > 0 && x >= 0 && y >= 0 && x + width_px <= image.width_px &&
                     y + height_px <= image.height_px,
                 "a picture beyond the image");
  const std::vector<std::uint8_t> filtered = Filtered(image, x, y, width_px, height_px, straightens);
  std::vector<std::uint32_t> counts(kSymbols, 0);
  // Each channel by itself, so that no sum waits for another.
  std::array<std::array<std::uint32_t, 256>, 4> counts_of{};
  Walk(
      filtered, width_px, height_px, [&](std::uint8_t byte) { ++counts[byte]; },
      [&](const std::uint8_t* pixel) {
        for (std::size_t c = 0; c < 4; ++c) ++counts_of[c][pixel[c]];
      },
      [&](int length) { ++counts[LengthOf(length).symbol]; });
  for (const auto& of_channel : counts_of) {
    for (std::size_t byte = 0; byte < of_channel.size(); ++byte) counts[byte] += of_channel[byte];
  }
  ++counts[kEndOfBlock];
  const HuffmanCode code = HuffmanCode::Of(counts);

  std::uint64_t bits = 3 + 5 + 5 + 4 + 19 * 3 + (kSymbols + 1) * 4;
  constexpr int kMaxMatchBits = 5 + 1;  // extra bits of the length, the distance
  for (std::size_t symbol = 0; symbol < kSymbols; ++symbol)
    bits += std::uint64_t{counts[symbol]} *
            (code.words[symbol].length + (symbol > kEndOfBlock ? kMaxMatchBits : 0));
  constexpr std::size_t kAroundChunk = 12, kHeader = 13, kZlibHeader = 2, kSum = 4;
  std::vector<std::uint8_t> png(
      kPngSignature.size() + 3 * kAroundChunk + kHeader + kZlibHeader + bits / 8 + 8 + kSum, 0);
  std::copy(kPngSignature.begin(), kPngSignature.end(), png.begin());
  std::uint8_t* chunk = png.data() + kPngSignature.size();
  PutBigEndian(static_cast<std::uint32_t>(width_px), chunk + 8);
  PutBigEndian(static_cast<std::uint32_t>(height_px), chunk + 12);
  chunk[16] = 8;  // bits a channel
  chunk[17] = 6;  // red, green, blue, alpha
  CloseChunk("IHDR", chunk, kHeader);
  chunk += kAroundChunk + kHeader;

  std::uint8_t* content = chunk + 8;
  content[0] = 0x78, content[1] = 0x01;  // deflate, 32 KiB window
  BitWriter out(content + kZlibHeader);
  PutCode(code, out);
  Walk(
      filtered, width_px, height_px, [&](std::uint8_t byte) { out.Put(code.words[byte]); },
      [&](const std::uint8_t* pixel) {
        out.Put(code.words[pixel[0]], code.words[pixel[1]]);
        out.Put(code.words[pixel[2]], code.words[pixel[3]]);
      },
      [&](int length) {
        const MatchLength match = LengthOf(length);
        out.Put(code.words[match.symbol]);
        out.Put(match.extra, match.extra_bits);
        out.Put(0, 1);
      });
  out.Put(code.words[kEndOfBlock]);
  std::uint8_t* end = out.Finish();
  PutBigEndian(libdeflate_adler32(1, filtered.data(), filtered.size()), end);
  const auto size = static_cast<std::size_t>(end + kSum - content);
  CloseChunk("IDAT", chunk, size);
  chunk += kAroundChunk + size;
  CloseChunk("IEND", chunk, 0);
  png.resize(static_cast<std::size_t>(chunk + kAroundChunk - png.data()));
  return png;
}

}  // namespace

std::vector<std::uint8_t> EncodePng(const RgbaImage& image, int x, int y, int size_px) {
  return EncodePart(image, x, y, size_px, size_px, /*straightens=*/true);
}

std::vector<std::uint8_t> EncodeWholePng(const RgbaImage& image) {
  return EncodePart(image, 0, 0, image.width_px, image.height_px, /*straightens=*/false);
}

}  // namespace skyquilt::image
