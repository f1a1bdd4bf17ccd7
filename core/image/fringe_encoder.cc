#include "core/image/fringe_encoder.h"

#include <webp/encode.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/base/check.h"
#include "core/image/huffman_code.h"
#include "core/image/yuv_planes.h"

namespace skyquilt::image {
namespace {

constexpr std::size_t kLiterals = 256, kLengthSymbols = 24, kGreenSymbols = kLiterals + kLengthSymbols;
constexpr std::size_t kMinCopy = 3, kMaxCopy = 4096;

// Where a copy comes from; RFC 9649 numbers the pixels nearby (5.2.2).
enum class Source : std::uint8_t { kNone, kAbove, kLeft };

// A value as it is, or a copy of some length.
struct Token {
  std::uint16_t symbol = 0;
  std::uint16_t extra = 0;
  std::uint8_t extra_bits = 0;
  Source source = Source::kNone;
};

// RFC 9649, 5.2.2: a length is written as a symbol and some bits.
Token CopyOf(std::size_t length, Source source) {
  const std::size_t over = length - 1;
  if (over < 4) return {static_cast<std::uint16_t>(kLiterals + over), 0, 0, source};
  const int highest = static_cast<int>(std::bit_width(over)) - 1, extra_bits = highest - 1;
  return {static_cast<std::uint16_t>(kLiterals + 2 * static_cast<std::size_t>(highest) +
                                     (over >> extra_bits & 1)),
          static_cast<std::uint16_t>(over & ((std::size_t{1} << extra_bits) - 1)),
          static_cast<std::uint8_t>(extra_bits), source};
}

// How far the values at `at` go on as those `distance` before.
std::size_t Run(std::span<const std::uint8_t> values, std::size_t at, std::size_t distance) {
  if (at < distance) return 0;
  const std::size_t end = std::min(values.size(), at + kMaxCopy);
  const std::uint8_t* const all = values.data();
  std::size_t to = at;
  for (; to + 8 <= end; to += 8) {
    std::uint64_t here = 0, before = 0;
    std::memcpy(&here, all + to, 8);
    std::memcpy(&before, all + to - distance, 8);
    if (here != before) break;
  }
  while (to < end && all[to] == all[to - distance]) ++to;
  return to - at;
}

std::vector<Token> TokensOf(std::span<const std::uint8_t> values, std::size_t width) {
  std::vector<Token> tokens;
  for (std::size_t at = 0; at < values.size();) {
    const std::size_t above = Run(values, at, width), left = Run(values, at, 1);
    const std::size_t length = std::max(above, left);
    if (length < kMinCopy) {
      tokens.push_back({values[at++], 0, 0, Source::kNone});
      continue;
    }
    tokens.push_back(CopyOf(length, above >= left ? Source::kAbove : Source::kLeft));
    at += length;
  }
  return tokens;
}

// RFC 9649, 6.2.1. The lengths of the code's words go by a code of their own: most in four bits, 14 and 15 in
// five, and one symbol for a run of symbols that never occur.
void PutGreenCode(const HuffmanCode& code, BitWriter& out) {
  constexpr std::array<int, 19> kOrder{17, 18, 0, 1, 2, 3, 4, 5, 16, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  constexpr unsigned kManyZeros = 18;
  constexpr std::size_t kMinZeros = 11, kMaxZeros = 138;
  out.Put(0, 1);  // no simple code
  out.Put(kOrder.size() - 4, 4);
  for (const int symbol : kOrder)
    out.Put(symbol == 16 || symbol == 17 ? 0 : symbol == 14 || symbol == 15 ? 5 : 4, 3);
  out.Put(0, 1);  // of all symbols
  const auto put = [&](unsigned symbol) {
    const bool is_rare = symbol == 14 || symbol == 15;
    const int bits = is_rare ? 5 : 4;
    const unsigned word = is_rare ? 16 + symbol : symbol == kManyZeros ? 14 : symbol;
    unsigned mirrored = 0;
    for (int bit = 0; bit < bits; ++bit) mirrored |= (word >> bit & 1U) << (bits - 1 - bit);
    out.Put(mirrored, bits);
  };
  for (std::size_t symbol = 0; symbol < kGreenSymbols;) {
    std::size_t zeros = 0;
    while (symbol + zeros < kGreenSymbols && zeros < kMaxZeros && code.words[symbol + zeros].length == 0)
      ++zeros;
    if (zeros < kMinZeros) {
      put(code.words[symbol++].length);
      continue;
    }
    put(kManyZeros);
    out.Put(zeros - kMinZeros, 7);
    symbol += zeros;
  }
}

// The content of the chunk ALPH: a lossless image (RFC 9649, 2.7.1.2) whose green is the alpha.
std::vector<std::uint8_t> PackAlpha(const RgbaImage& image) {
  std::vector<std::uint8_t> values(image.rgba.size() / 4);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = image.rgba[4 * i + 3];
  const std::vector<Token> tokens = TokensOf(values, static_cast<std::size_t>(image.width_px));
  std::vector<std::uint32_t> counts(kGreenSymbols, 0);
  for (const Token& token : tokens) ++counts[token.symbol];
  // A code is of two symbols or more.
  ++counts[0];
  ++counts[kLiterals - 1];
  const HuffmanCode code = HuffmanCode::Of(counts);

  constexpr std::size_t kHeadBits = 64 + 19 * 3 + kGreenSymbols * 5;
  constexpr std::size_t kTokenBits = 15 + 10 + 1;
  std::vector<std::uint8_t> packed(1 + (kHeadBits + kTokenBits * tokens.size()) / 8 + 8);
  packed[0] = 1;  // packed without loss, no filter
  BitWriter out(packed.data() + 1);
  out.Put(0, 3);  // no transform, no cache of colours, one set of codes
  PutGreenCode(code, out);
  for (int channel = 0; channel < 3; ++channel) out.Put(0b0001, 4);  // red, blue and alpha: 0 in no bits
  out.Put(0b0011, 4);  // where copies come from: one bit, 0 is above,
  out.Put(1, 8);       // and 1 to the left
  for (const Token& token : tokens) {
    out.Put(code.words[token.symbol]);
    if (token.source == Source::kNone) continue;
    out.Put(token.extra, token.extra_bits);
    out.Put(token.source == Source::kLeft ? 1 : 0, 1);
  }
  packed.resize(static_cast<std::size_t>(out.Finish() - packed.data()));
  return packed;
}

int Append(const std::uint8_t* part, std::size_t size, const WebPPicture* of) {
  auto& all = *static_cast<std::vector<std::uint8_t>*>(of->custom_ptr);
  try {
    all.insert(all.end(), part, part + size);
  } catch (const std::bad_alloc&) {
    return 0;  // the encoder fails, which is told: no exception may pass through it
  }
  return 1;
}

// A whole WebP of the colours alone; where alpha is 0 they are whatever takes least.
std::vector<std::uint8_t> EncodeColours(const RgbaImage& image, float quality) {
  WebPConfig config;
  WebPPicture picture;
  if (WebPConfigPreset(&config, WEBP_PRESET_DEFAULT, quality) == 0 || WebPPictureInit(&picture) == 0)
    throw std::runtime_error("WebP encoder: a quality beyond 100, or another version of the library");
  const std::unique_ptr<WebPPicture, void (*)(WebPPicture*)> owner(&picture, WebPPictureFree);
  config.method = 0;
  picture.width = image.width_px;
  picture.height = image.height_px;
  std::vector<std::uint8_t> bytes;
  picture.writer = Append;
  picture.custom_ptr = &bytes;
  picture.use_argb = 0;
  picture.colorspace = WEBP_YUV420A;
  bool is_good = WebPPictureAlloc(&picture) != 0;
  if (is_good) {
    FillYuvPlanes(image, {picture.y, picture.u, picture.v, picture.a, picture.y_stride, picture.uv_stride,
                          picture.a_stride});
    WebPCleanupTransparentArea(&picture);
    picture.a = nullptr;
    picture.colorspace = WEBP_YUV420;
    is_good = WebPEncode(&config, &picture) != 0;
  }
  if (!is_good) throw std::runtime_error("WebP encoder: error " + std::to_string(picture.error_code));
  return bytes;
}

void PutNumber(std::uint32_t value, int bytes, std::vector<std::uint8_t>& out) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

void PutName(std::string_view name, std::vector<std::uint8_t>& out) {
  for (const char c : name) out.push_back(static_cast<std::uint8_t>(c));
}

}  // namespace

std::vector<std::uint8_t> EncodeFringeWebp(const RgbaImage& straight, float quality) {
  SKYQUILT_CHECK(straight.width_px > 0 && straight.height_px > 0 && straight.width_px <= WEBP_MAX_DIMENSION &&
                     straight.height_px <= WEBP_MAX_DIMENSION,
                 "a picture that WebP cannot hold");
  constexpr std::size_t kFileHead = 12, kFeatures = 10;
  constexpr std::uint32_t kHasAlpha = 0x10;
  const std::vector<std::uint8_t> colours = EncodeColours(straight, quality);
  const std::vector<std::uint8_t> alpha = PackAlpha(straight);
  const auto alpha_bytes = static_cast<std::uint32_t>(alpha.size());
  const std::uint32_t padding = alpha_bytes & 1;
  std::vector<std::uint8_t> webp;
  webp.reserve(colours.size() + alpha.size() + 64);
  PutName("RIFF", webp);
  PutNumber(
      static_cast<std::uint32_t>(4 + 8 + kFeatures + 8 + alpha_bytes + padding + colours.size() - kFileHead),
      4, webp);
  PutName("WEBPVP8X", webp);
  PutNumber(kFeatures, 4, webp);
  PutNumber(kHasAlpha, 4, webp);
  PutNumber(static_cast<std::uint32_t>(straight.width_px - 1), 3, webp);
  PutNumber(static_cast<std::uint32_t>(straight.height_px - 1), 3, webp);
  PutName("ALPH", webp);
  PutNumber(alpha_bytes, 4, webp);
  webp.insert(webp.end(), alpha.begin(), alpha.end());
  if (padding != 0) webp.push_back(0);
  webp.insert(webp.end(), colours.begin() + kFileHead, colours.end());
  return webp;
}

std::vector<std::uint8_t> EncodeFringe(const RgbaImage& straight, int jpeg_quality) {
  constexpr int kMaxBelowJpeg = 21;
  const int below = std::min({kMaxBelowJpeg, 3 * (100 - jpeg_quality) / 2, jpeg_quality - 1});
  return EncodeFringeWebp(straight, static_cast<float>(jpeg_quality - below));
}

}  // namespace skyquilt::image
