#include "core/image/png_decoder.h"

#include <png.h>

#include <algorithm>
#include <array>
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

constexpr std::size_t kInterlaceAt = 28;  // in the header chunk, which comes first

struct Input {
  std::span<const std::uint8_t> left;
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
  std::memcpy(out, input->left.data(), size);
  input->left = input->left.subspan(size);
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

DecodeOutcome Read(png_structp png, png_infop info, const ScaledBox& wish, Buffers& buffers,
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
  const int passes = png_set_interlace_handling(png);
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
  Input input{bytes, {}};
  DestroyPng owner;
  owner.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &input, OnError, OnWarning);
  if (owner.png == nullptr) throw std::bad_alloc();
  owner.info = png_create_info_struct(owner.png);
  if (owner.info == nullptr) throw std::bad_alloc();
  png_set_read_fn(owner.png, &input, OnRead);
  // The header was checked by its own limits; libpng's is a million a side.
  Buffers buffers;
  switch (Read(owner.png, owner.info, wish, buffers, part)) {
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
