#include "core/image/jpeg_decoder.h"

#include <csetjmp>
#include <cstddef>
#include <cstdio>
// libjpeg's headers want those above, and in this order.
#include <jerror.h>
#include <jpeglib.h>

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "core/image/decode_errors.h"

namespace skyquilt::image {
namespace {

// Colours beside a cut are smoothed as at the picture's edge: so many pixels around are decoded with it.
constexpr int kAroundPx = 16;
constexpr int kMaxScans = 500;  // of a progressive picture; more are made to keep a decoder busy

// What libjpeg calls back; it leaves by longjmp, so that nothing between may need a destructor.
struct Callbacks {
  jpeg_error_mgr errors;
  jpeg_progress_mgr progress;
  std::jmp_buf leave;
  std::array<char, JMSG_LENGTH_MAX> message;
};

[[noreturn]] void Leave(j_common_ptr jpeg) {
  auto* callbacks = static_cast<Callbacks*>(jpeg->client_data);
  jpeg->err->format_message(jpeg, callbacks->message.data());
  std::longjmp(callbacks->leave, 1);
}

void OnMessage(j_common_ptr jpeg, int level) {
  // Below 0 are warnings, after which pixels are guessed. Nothing is lost by what some cameras and phones
  // write: stray bytes between segments, a scan of all coefficients that names another range of them, a
  // version of JFIF that there is not.
  constexpr std::array<int, 3> kHarmless{JWRN_EXTRANEOUS_DATA, JWRN_NOT_SEQUENTIAL, JWRN_JFIF_MAJOR};
  const bool is_harmless =
      std::find(kHarmless.begin(), kHarmless.end(), jpeg->err->msg_code) != kHarmless.end();
  if (level < 0 && !is_harmless) Leave(jpeg);
}

void OnProgress(j_common_ptr jpeg) {
  if (!jpeg->is_decompressor) return;
  if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= kMaxScans) return;
  auto* callbacks = static_cast<Callbacks*>(jpeg->client_data);
  constexpr std::array kTooMany = std::to_array("too many scans");
  std::copy(kTooMany.begin(), kTooMany.end(), callbacks->message.begin());
  std::longjmp(callbacks->leave, 1);
}

// Destroyed wherever its reading was left.
struct Decoder {
  Callbacks callbacks{};
  jpeg_decompress_struct jpeg{};

  Decoder() {
    jpeg.err = jpeg_std_error(&callbacks.errors);
    callbacks.errors.error_exit = Leave;
    callbacks.errors.emit_message = OnMessage;
    callbacks.progress.progress_monitor = OnProgress;
    jpeg.client_data = &callbacks;
  }
  ~Decoder() { jpeg_destroy_decompress(&jpeg); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
};

struct Wish {
  std::span<const std::uint8_t> bytes;
  int width_px, height_px, denominator;
  const PixelBox* box;  // null: everything
};

// No object with a destructor may live in it: damage leaves it by longjmp.
DecodeOutcome Read(jpeg_decompress_struct& jpeg, Callbacks& callbacks, const Wish& wish, DecodedPart& part,
                   PixelBytes& cmyk) {
  if (setjmp(callbacks.leave) != 0) return DecodeOutcome::kDamaged;
  jpeg_create_decompress(&jpeg);
  jpeg.progress = &callbacks.progress;
  jpeg_mem_src(&jpeg, wish.bytes.data(), static_cast<unsigned long>(wish.bytes.size()));
  jpeg_read_header(&jpeg, TRUE);
  if (static_cast<int>(jpeg.image_width) != wish.width_px ||
      static_cast<int>(jpeg.image_height) != wish.height_px)
    return DecodeOutcome::kChanged;
  jpeg.scale_num = 1;
  jpeg.scale_denom = static_cast<unsigned>(wish.denominator);
  const bool is_cmyk = jpeg.jpeg_color_space == JCS_CMYK || jpeg.jpeg_color_space == JCS_YCCK;
  jpeg.out_color_space = is_cmyk ? JCS_CMYK : JCS_RGB;
  jpeg_start_decompress(&jpeg);
  JDIMENSION left = 0, width = jpeg.output_width;
  int top = 0, bottom = static_cast<int>(jpeg.output_height);
  if (wish.box != nullptr) {
    const int right = std::min(static_cast<int>(jpeg.output_width), wish.box->right + kAroundPx);
    left = static_cast<JDIMENSION>(std::clamp(wish.box->left - kAroundPx, 0, right - 1));
    width = static_cast<JDIMENSION>(right) - left;
    bottom = std::min(bottom, wish.box->bottom + kAroundPx);
    top = std::clamp(wish.box->top - kAroundPx, 0, bottom - 1);
    jpeg_crop_scanline(&jpeg, &left, &width);
  }
  part.left_px = static_cast<int>(left);
  part.top_px = top;
  part.image.width_px = static_cast<int>(width);
  part.image.height_px = bottom - top;
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(bottom - top);
  part.image.rgb.resize(3 * pixels);
  if (is_cmyk) cmyk.resize(4 * pixels);
  if (top > 0) jpeg_skip_scanlines(&jpeg, static_cast<JDIMENSION>(top));
  JSAMPLE* const first = is_cmyk ? cmyk.data() : part.image.rgb.data();
  const std::size_t stride = (is_cmyk ? 4 : 3) * static_cast<std::size_t>(width);
  while (static_cast<int>(jpeg.output_scanline) < bottom) {
    JSAMPROW row =
        first + (static_cast<std::size_t>(jpeg.output_scanline) - static_cast<std::size_t>(top)) * stride;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  // Damage behind the last row shows only here.
  if (wish.box == nullptr) jpeg_finish_decompress(&jpeg);
  return DecodeOutcome::kDecoded;
}

struct ScanFacts {
  bool has_several_scans = false;
  int components = 0;
};

// No object with a destructor may live in it either. What is damaged is found when it is decoded.
ScanFacts ReadScanFacts(jpeg_decompress_struct& jpeg, Callbacks& callbacks,
                        std::span<const std::uint8_t> bytes) {
  if (setjmp(callbacks.leave) != 0) return {};
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, bytes.data(), static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&jpeg, TRUE);
  return {jpeg_has_multiple_scans(&jpeg) != 0, jpeg.num_components};
}

// Adobe's CMYK is stored inverted, and that is how all JPEGs with four components come.
void RgbFromInvertedCmyk(const PixelBytes& cmyk, PixelBytes& rgb) {
  for (std::size_t i = 0; i < cmyk.size() / 4; ++i) {
    const int black = cmyk[4 * i + 3];
    for (std::size_t c = 0; c < 3; ++c)
      rgb[3 * i + c] = static_cast<std::uint8_t>(cmyk[4 * i + c] * black / 255);
  }
}

}  // namespace

std::int64_t JpegWorkBytes(std::span<const std::uint8_t> bytes, int width_px, int height_px) {
  Decoder decoder;
  const ScanFacts facts = ReadScanFacts(decoder.jpeg, decoder.callbacks, bytes);
  const std::int64_t pixels = std::int64_t{width_px} * height_px;
  const std::int64_t rows = std::int64_t{100} * width_px;
  return rows + (facts.has_several_scans ? 2 * pixels * facts.components : 0) +
         (facts.components == 4 ? 4 * pixels : 0);
}

Result<DecodedPart> DecodeJpeg(std::span<const std::uint8_t> bytes, int width_px, int height_px,
                               int denominator, const std::optional<PixelBox>& box, PixelBytes memory) {
  const PixelBox whole{0, 0, (width_px + denominator - 1) / denominator,
                       (height_px + denominator - 1) / denominator};
  const PixelBox* const wanted = box && !box->Contains(whole) ? &*box : nullptr;
  DecodedPart part;
  part.image.rgb = std::move(memory);
  part.image.rgb.clear();  // or what is in it would be moved when it grows
  PixelBytes cmyk;
  Decoder decoder;
  const Callbacks& callbacks = decoder.callbacks;
  const DecodeOutcome outcome =
      Read(decoder.jpeg, decoder.callbacks, {bytes, width_px, height_px, denominator, wanted}, part, cmyk);
  if (outcome == DecodeOutcome::kChanged) return PictureChanged();
  if (outcome == DecodeOutcome::kDamaged && callbacks.errors.msg_code == JERR_OUT_OF_MEMORY)
    throw std::bad_alloc();
  if (outcome == DecodeOutcome::kDamaged) return PictureDamaged(callbacks.message.data());
  if (!cmyk.empty()) RgbFromInvertedCmyk(cmyk, part.image.rgb);
  return part;
}

}  // namespace skyquilt::image
