#include "core/image/png_tile.h"

#include <libdeflate.h>

#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace skyquilt::image {
namespace {

constexpr std::string_view kPngMagic = "\x89PNG\r\n\x1a\n";
constexpr std::size_t kPixel = 4;

std::uint32_t BigEndian(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[i]);
  return value;
}

// The compressed rows of a picture of this size; nothing if it is not one.
std::optional<std::string> CompressedRowsOf(std::string_view png, int side_px) {
  if (!png.starts_with(kPngMagic)) return std::nullopt;
  png.remove_prefix(kPngMagic.size());
  std::string rows;
  bool is_tile = false;
  while (png.size() >= 12) {
    const std::size_t size = BigEndian(png.data());
    if (size > png.size() - 12) return std::nullopt;
    const std::string_view name = png.substr(4, 4), content = png.substr(8, size);
    if (libdeflate_crc32(0, name.data(), size + 4) != BigEndian(content.data() + size)) return std::nullopt;
    if (name == "IHDR") {
      const auto side = static_cast<std::uint32_t>(side_px);
      is_tile = size == 13 && BigEndian(content.data()) == side && BigEndian(content.data() + 4) == side &&
                content.substr(8) == std::string_view("\x08\x06\0\0\0", 5);
    } else if (name == "IDAT") {
      rows += content;
    } else if (name == "IEND") {
      if (is_tile) return rows;
      return std::nullopt;
    }
    png.remove_prefix(12 + size);
  }
  return std::nullopt;
}

int Paeth(int left, int up, int corner) {
  const int to_left = std::abs(up - corner), to_up = std::abs(left - corner),
            to_corner = std::abs(left + up - 2 * corner);
  if (to_left <= to_up && to_left <= to_corner) return left;
  return to_up <= to_corner ? up : corner;
}

// The filter of our own tiles: adds the mean of the pixel to the left and the one above.
void AddMeans(const std::uint8_t* above, std::size_t count, std::uint8_t* row) {
#if defined(__SSE2__)
  const auto load = [](const std::uint8_t* pixel) {
    std::int32_t bytes = 0;
    std::memcpy(&bytes, pixel, kPixel);
    return _mm_cvtsi32_si128(bytes);
  };
  const __m128i one = _mm_set1_epi8(1);
  __m128i left = _mm_setzero_si128();
  for (std::size_t i = 0; i < count; i += kPixel) {
    const __m128i up = load(above + i);
    // What rounds up, made to round down.
    const __m128i mean = _mm_sub_epi8(_mm_avg_epu8(left, up), _mm_and_si128(_mm_xor_si128(left, up), one));
    left = _mm_add_epi8(load(row + i), mean);
    const std::int32_t bytes = _mm_cvtsi128_si32(left);
    std::memcpy(row + i, &bytes, kPixel);
  }
#else
  for (std::size_t i = 0; i < count; ++i)
    row[i] = static_cast<std::uint8_t>(row[i] + ((*(row + i - kPixel) + above[i]) >> 1));
#endif
}

// Adds what the row's filter predicts from the pixel to the left and the row above. `row` and `above` have
// one pixel of zeros before them.
bool Unfilter(int filter, const std::uint8_t* above, std::size_t count, std::uint8_t* row) {
  const auto add = [&](auto&& predict) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint8_t* up = above + i;
      row[i] = static_cast<std::uint8_t>(row[i] + predict(*(row + i - kPixel), *up, *(up - kPixel)));
    }
  };
  switch (filter) {
    case 0:
      return true;
    case 1:
      add([](int left, int, int) { return left; });
      return true;
    case 2:
      add([](int, int up, int) { return up; });
      return true;
    case 3:
      AddMeans(above, count, row);
      return true;
    case 4:
      add(Paeth);
      return true;
    default:
      return false;
  }
}

}  // namespace

Result<RgbaImage> DecodePngTile(std::string_view bytes, int side_px) {
  const Error damaged{ErrorCode::kCorrupt, "A stored tile is damaged. Stitch the flight again.", ""};
  const std::optional<std::string> packed = CompressedRowsOf(bytes, side_px);
  if (!packed) return damaged;
  const auto side = static_cast<std::size_t>(side_px);
  const std::size_t row_bytes = kPixel * side;
  std::vector<std::uint8_t> filtered((row_bytes + 1) * side);
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> inflater(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!inflater) throw std::bad_alloc();
  if (libdeflate_zlib_decompress(inflater.get(), packed->data(), packed->size(), filtered.data(),
                                 filtered.size(), nullptr) != LIBDEFLATE_SUCCESS) {
    return damaged;
  }
  RgbaImage image{side_px, side_px, {}};
  image.rgba.resize(row_bytes * side);
  std::vector<std::uint8_t> above(kPixel + row_bytes, 0), row(kPixel + row_bytes, 0);
  for (std::size_t y = 0; y < side; ++y) {
    const std::uint8_t* in = filtered.data() + y * (row_bytes + 1);
    std::memcpy(row.data() + kPixel, in + 1, row_bytes);
    if (!Unfilter(in[0], above.data() + kPixel, row_bytes, row.data() + kPixel)) return damaged;
    std::memcpy(image.rgba.data() + y * row_bytes, row.data() + kPixel, row_bytes);
    std::swap(above, row);
  }
  return image;
}

}  // namespace skyquilt::image
