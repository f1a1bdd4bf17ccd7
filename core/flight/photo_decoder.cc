#include "core/flight/photo_decoder.h"

#include <turbojpeg.h>

#include <algorithm>
#include <memory>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/check.h"
#include "core/flight/byte_source.h"
#include "core/flight/read_photo.h"

namespace skyquilt::flight {
namespace {

using pipeline::DecodedImage;

struct TurboDeleter {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Turbo = std::unique_ptr<std::remove_pointer_t<tjhandle>, TurboDeleter>;

Error Damaged(std::string detail) {
  return {ErrorCode::kCorrupt,
          "The picture is damaged or cut off and cannot be decoded. Copy the file from the camera again.",
          std::move(detail)};
}

Error Changed() {
  return {ErrorCode::kCorrupt,
          "The picture is not the size its header said; the file has changed. Add it again.", ""};
}

int CeilDiv(int a, int b) { return (a + b - 1) / b; }

// Some cameras leave stray bytes between segments; libjpeg says so and loses nothing by it.
bool IsHarmlessWarning(std::string_view message) {
  return message.find("extraneous bytes before marker") != std::string_view::npos;
}

// Adobe's CMYK is stored inverted, and that is how all JPEGs with four components come.
void RgbFromInvertedCmyk(const PixelBytes& cmyk, PixelBytes& rgb) {
  for (std::size_t i = 0; i < cmyk.size() / 4; ++i) {
    const int black = cmyk[4 * i + 3];
    for (std::size_t c = 0; c < 3; ++c)
      rgb[3 * i + c] = static_cast<std::uint8_t>(cmyk[4 * i + c] * black / 255);
  }
}

Result<DecodedImage> DecodeJpeg(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                                int denominator) {
  const Turbo turbo(tjInitDecompress());
  if (!turbo) throw std::bad_alloc();
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  tjDecompressHeader3(turbo.get(), bytes.data(), bytes.size(), &width, &height, &subsampling, &colorspace);
  if (width <= 0 || height <= 0) return Damaged(tjGetErrorStr2(turbo.get()));
  if (width != width_px || height != height_px) return Changed();
  DecodedImage image;
  image.width_px = CeilDiv(width, denominator);
  image.height_px = CeilDiv(height, denominator);
  const std::size_t pixels =
      static_cast<std::size_t>(image.width_px) * static_cast<std::size_t>(image.height_px);
  image.rgb.resize(3 * pixels);
  const bool is_cmyk = colorspace == TJCS_CMYK || colorspace == TJCS_YCCK;
  PixelBytes cmyk(is_cmyk ? 4 * pixels : 0);
  const int status =
      tjDecompress2(turbo.get(), bytes.data(), bytes.size(), is_cmyk ? cmyk.data() : image.rgb.data(),
                    image.width_px, 0, image.height_px, is_cmyk ? TJPF_CMYK : TJPF_RGB, TJFLAG_LIMITSCANS);
  if (status != 0) {
    const std::string message = tjGetErrorStr2(turbo.get());
    if (tjGetErrorCode(turbo.get()) == TJERR_FATAL || !IsHarmlessWarning(message)) return Damaged(message);
  }
  if (is_cmyk) RgbFromInvertedCmyk(cmyk, image.rgb);
  return image;
}

Result<DecodedImage> DecodeByOpenCv(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                                    int denominator) {
  cv::Mat bgr;
  try {
    bgr = cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return Damaged(error.what());
  }
  if (bgr.empty()) return Damaged("no picture came out");
  if (bgr.cols != width_px || bgr.rows != height_px) return Changed();
  if (denominator > 1) {
    const int width = CeilDiv(width_px, denominator);
    const int height = CeilDiv(height_px, denominator);
    cv::copyMakeBorder(bgr, bgr, 0, height * denominator - height_px, 0, width * denominator - width_px,
                       cv::BORDER_REPLICATE);
    cv::Mat smaller;
    cv::resize(bgr, smaller, cv::Size(width, height), 0, 0, cv::INTER_AREA);
    bgr = smaller;
  }
  DecodedImage image;
  image.width_px = bgr.cols;
  image.height_px = bgr.rows;
  image.rgb.resize(3 * bgr.total());
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.rgb.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return image;
}

}  // namespace

Result<DecodedImage> DecodePhotoBytes(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                                      int denominator) {
  SKYQUILT_CHECK(denominator == 1 || denominator == 2 || denominator == 4 || denominator == 8,
                 "photos are decoded at 1, 1/2, 1/4 or 1/8");
  if (bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF) {
    return DecodeJpeg(bytes, width_px, height_px, denominator);
  }
  return DecodeByOpenCv(bytes, width_px, height_px, denominator);
}

Result<DecodedImage> FilePhotoSource::Decode(const Photo& photo, int denominator) const {
  constexpr std::uint64_t kMaxFile = std::uint64_t{3} << 30;
  auto source = OpenFileBytes(photo.path);
  if (!source) return source.error();
  const std::uint64_t size = (*source)->size();
  if (size > kMaxFile) return Error{ErrorCode::kTooLarge, "The picture's file is larger than 3 GiB.", ""};
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  if (!(*source)->Read(0, bytes)) {
    return Error{ErrorCode::kIo, "The picture's file cannot be read from the disk.", photo.path.string()};
  }
  return DecodePhotoBytes(bytes, photo.intrinsics.width_px, photo.intrinsics.height_px, denominator);
}

}  // namespace skyquilt::flight
