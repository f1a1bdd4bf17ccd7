#include "core/image/png_decoder.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "core/image/decode_errors.h"

namespace skyquilt::image {
namespace {

// In the header chunk, which comes first.
constexpr std::size_t kWidthAt = 16, kHeightAt = 20, kDepthAt = 24, kColourAt = 25, kInterlaceAt = 28;
constexpr std::size_t kHeaderEnd = 33;
constexpr std::size_t kMaxBehindRows = 64 * 1024;  // some writers end late by a few bytes
constexpr const char* kGoesOn = "its rows go on behind the last that its header has";
constexpr png_uint_32 kIdat = 0x49444154;

struct Input {
  std::span<const std::uint8_t> left;
  std::int64_t rows_left = 0;   // of all passes
  std::size_t behind_rows = 0;  // bytes of rows that were read when none was left
  std::array<char, 200> message{};
};

// libpng leaves by longjmp, so that nothing between may need a destructor.
[[noreturn]] void OnError(png_structp png, png_const_charp message) {
  auto* input = static_cast<Input*>(png_get_error_ptr(png));
  std::strncpy(input->message.data(), message, input->message.size() - 1);
  png_longjmp(png, 1);
}

void OnWarning(png_structp, png_const_charp) {}  // of chunks that do not concern the pixels

void OnRead(png_structp png, png_bytep out, png_size_t size) {
  auto* input = static_cast<Input*>(png_get_io_ptr(png));
  if (input->left.size() < size) png_error(png, "the file ends too early");
  if (input->rows_left <= 0 && png_get_io_chunk_type(png) == kIdat) {
    input->behind_rows += size;
    if (input->behind_rows > kMaxBehindRows) png_error(png, kGoesOn);
  }
  std::memcpy(out, input->left.data(), size);
  input->left = input->left.subspan(size);
}

// Called for each row before libpng looks whether the compressed rows end with the last.
void OnRow(png_structp png, png_row_infop, png_bytep) {
  --static_cast<Input*>(png_get_io_ptr(png))->rows_left;
}

// Rows of all passes, and the bytes that they have before they are compressed.
struct PngRowCount {
  std::int64_t rows = 0, bytes = 0;
};
PngRowCount CountPngRows(std::int64_t width_px, std::int64_t height_px, int bits, bool is_interlaced) {
  PngRowCount count;
  const auto add = [&](std::int64_t columns, std::int64_t rows) {
    if (columns == 0) return;
    count.rows += rows;
    count.bytes += rows * (1 + (columns * bits + 7) / 8);
  };
  if (!is_interlaced) add(width_px, height_px);
  for (int pass = 0; is_interlaced && pass < PNG_INTERLACE_ADAM7_PASSES; ++pass)
    add(PNG_PASS_COLS(width_px, pass), PNG_PASS_ROWS(height_px, pass));
  return count;
}

std::uint32_t BigEndianAt(std::span<const std::uint8_t> bytes, std::size_t at) {
  return png_get_uint_32(bytes.data() + at);
}

bool IsInterlaced(std::span<const std::uint8_t> bytes) {
  return bytes.size() > kInterlaceAt && bytes[kInterlaceAt] != 0;
}

struct ScaledBox {
  int width_px, height_px, denominator;
  PixelBox box;  // at that scale, within the picture
};

// Adds a row of the picture to the sums of a row of the result; columns beyond the border repeat it.
void AddRow(const std::uint8_t* row, const ScaledBox& wish, std::uint32_t* sums) {
  const int d = wish.denominator, last = wish.width_px - 1;
  for (int x = wish.box.left; x < wish.box.right; ++x, sums += 3) {
    for (int dx = 0; dx < d; ++dx) {
      const std::uint8_t* pixel = row + 3 * static_cast<std::size_t>(std::min(x * d + dx, last));
      sums[0] += pixel[0], sums[1] += pixel[1], sums[2] += pixel[2];
    }
  }
}

struct Buffers {
  std::vector<std::uint8_t> rows;  // one, or all of an interlaced picture
  std::vector<png_bytep> of_row;   // of an interlaced picture
  std::vector<std::uint32_t> sums;
};

DecodeOutcome Read(png_structp png, png_infop info, Input& input, const ScaledBox& wish, Buffers& buffers,
                   DecodedPart& part) {
  if (setjmp(png_jmpbuf(png)) != 0) return DecodeOutcome::kDamaged;
  png_read_info(png, info);
  if (png_get_image_width(png, info) != static_cast<png_uint_32>(wish.width_px) ||
      png_get_image_height(png, info) != static_cast<png_uint_32>(wish.height_px))
    return DecodeOutcome::kChanged;
  png_set_strip_16(png);
  png_set_strip_alpha(png);
  png_set_expand(png);
  png_set_gray_to_rgb(png);
  png_set_read_user_transform_fn(png, OnRow);
  const int passes = png_set_interlace_handling(png);
  input.rows_left = CountPngRows(wish.width_px, wish.height_px, 0, passes > 1).rows;
  png_read_update_info(png, info);
  const std::size_t stride = 3 * static_cast<std::size_t>(wish.width_px);
  // Transparency that png_set_expand made of a colour is stripped too: all rows are RGB.
  if (png_get_rowbytes(png, info) != stride) return DecodeOutcome::kDamaged;
  const bool is_whole = passes > 1;
  buffers.rows.resize(is_whole ? stride * static_cast<std::size_t>(wish.height_px) : stride);
  if (is_whole) {
    for (int y = 0; y < wish.height_px; ++y)
      buffers.of_row.push_back(buffers.rows.data() + static_cast<std::size_t>(y) * stride);
    png_read_image(png, buffers.of_row.data());
  }
  const int d = wish.denominator;
  const std::size_t width = static_cast<std::size_t>(wish.box.right - wish.box.left);
  buffers.sums.resize(3 * width);
  std::uint8_t* out = part.image.rgb.data();
  int next = 0;  // row of the picture that libpng hands out next
  const std::uint8_t* row = nullptr;
  const auto row_at = [&](int y) {
    y = std::min(y, wish.height_px - 1);
    if (is_whole)
      return const_cast<const std::uint8_t*>(buffers.rows.data()) + static_cast<std::size_t>(y) * stride;
    for (; next <= y; ++next) png_read_row(png, buffers.rows.data(), nullptr);
    return const_cast<const std::uint8_t*>(buffers.rows.data());
  };
  for (int y = wish.box.top; y < wish.box.bottom; ++y, out += 3 * width) {
    if (d == 1) {
      row = row_at(y);
      std::memcpy(out, row + 3 * static_cast<std::size_t>(wish.box.left), 3 * width);
      continue;
    }
    std::fill(buffers.sums.begin(), buffers.sums.end(), 0U);
    for (int dy = 0; dy < d; ++dy) AddRow(row_at(y * d + dy), wish, buffers.sums.data());
    const auto pixels = static_cast<std::uint32_t>(d * d);
    for (std::size_t i = 0; i < 3 * width; ++i)
      out[i] = static_cast<std::uint8_t>((buffers.sums[i] + pixels / 2) / pixels);
  }
  // Damage behind the last row shows only here.
  if (wish.box.bottom * d >= wish.height_px) png_read_end(png, nullptr);
  return DecodeOutcome::kDecoded;
}

struct DestroyPng {
  png_structp png = nullptr;
  png_infop info = nullptr;
  ~DestroyPng() { png_destroy_read_struct(&png, &info, nullptr); }
};

}  // namespace

bool IsPng(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= kPngSignature.size() &&
         std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin());
}

Result<void> CheckPngEnds(std::span<const std::uint8_t> bytes) {
  if (!IsPng(bytes) || bytes.size() < kHeaderEnd) return {};
  constexpr std::array<int, 7> kChannels{1, 0, 3, 1, 2, 0, 4};  // by kind of colour
  const std::size_t colour = bytes[kColourAt];
  const int channels = colour < kChannels.size() ? kChannels[colour] : 0;
  if (channels == 0 || bytes[kDepthAt] > 16) return {};
  const auto side_at = [&](std::size_t at) { return std::min(BigEndianAt(bytes, at), 1U << 20); };
  std::int64_t left =
      CountPngRows(side_at(kWidthAt), side_at(kHeightAt), channels * bytes[kDepthAt], IsInterlaced(bytes))
          .bytes;
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_streamp)> owner(&stream, &inflateEnd);
  std::vector<std::uint8_t> scratch(kMaxBehindRows);
  for (std::size_t at = kPngSignature.size(); bytes.size() - at >= 12;) {
    const std::size_t size = BigEndianAt(bytes, at);
    if (size > bytes.size() - at - 12) break;
    if (BigEndianAt(bytes, at + 4) == kIdat) {
      stream.next_in = const_cast<Bytef*>(bytes.data() + at + 8);
      stream.avail_in = static_cast<uInt>(size);
      do {
        stream.next_out = scratch.data();
        stream.avail_out = static_cast<uInt>(scratch.size());
        const int code = inflate(&stream, Z_NO_FLUSH);
        left -= static_cast<std::int64_t>(scratch.size() - stream.avail_out);
        if (left < -static_cast<std::int64_t>(kMaxBehindRows)) return PictureDamaged(kGoesOn);
        if (code != Z_OK && code != Z_BUF_ERROR) return {};
      } while (stream.avail_out == 0);
    }
    at += 12 + size;
  }
  return {};
}

std::int64_t PngWorkBytes(std::span<const std::uint8_t> bytes, int width_px, int height_px) {
  const std::int64_t row = std::int64_t{20} * width_px;  // libpng's two of 16 bits and alpha, ours, the sums
  return IsInterlaced(bytes) ? row + std::int64_t{3} * width_px * height_px : row;
}

Result<DecodedPart> DecodePng(std::span<const std::uint8_t> bytes, int width_px, int height_px,
                              int denominator, const std::optional<PixelBox>& box, PixelBytes memory) {
  const PixelBox whole{0, 0, (width_px + denominator - 1) / denominator,
                       (height_px + denominator - 1) / denominator};
  const ScaledBox wish{width_px, height_px, denominator, box ? box->Within(whole) : whole};
  DecodedPart part;
  part.left_px = wish.box.left;
  part.top_px = wish.box.top;
  part.image.width_px = std::max(0, wish.box.right - wish.box.left);
  part.image.height_px = std::max(0, wish.box.bottom - wish.box.top);
  part.image.rgb = std::move(memory);
  part.image.rgb.clear();  // or what is in it would be moved when it grows
  if (wish.box.IsEmpty()) return part;
  part.image.rgb.resize(3 * static_cast<std::size_t>(part.image.width_px) *
                        static_cast<std::size_t>(part.image.height_px));
  Input input;
  input.left = bytes;
  input.rows_left = 1;  // until the header was read
  DestroyPng owner;
  owner.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &input, OnError, OnWarning);
  if (owner.png == nullptr) throw std::bad_alloc();
  owner.info = png_create_info_struct(owner.png);
  if (owner.info == nullptr) throw std::bad_alloc();
  png_set_read_fn(owner.png, &input, OnRead);
  // Profiles and texts, each of which may unpack to megabytes.
  png_set_keep_unknown_chunks(owner.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  // The header was checked by its own limits; libpng's is a million a side.
  Buffers buffers;
  switch (Read(owner.png, owner.info, input, wish, buffers, part)) {
    case DecodeOutcome::kChanged:
      return PictureChanged();
    case DecodeOutcome::kDamaged:
      return PictureDamaged(input.message[0] != '\0' ? std::string(input.message.data()) : "not RGB");
    case DecodeOutcome::kDecoded:
      break;
  }
  return part;
}

}  // namespace skyquilt::image
