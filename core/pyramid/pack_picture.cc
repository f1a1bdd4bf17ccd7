#include "core/pyramid/pack_picture.h"

#include <new>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/pyramid/png_encoder.h"

namespace skyquilt::pyramid {

std::vector<std::uint8_t> PackPicture(const RgbaImage& picture) {
  SKYQUILT_CHECK(picture.width_px == picture.height_px, "only squares are packed");
  return EncodePng(picture, 0, 0, picture.width_px, PngAlpha::kAsItIs);
}

Result<RgbaImage> UnpackPicture(std::span<const std::uint8_t> packed, int side_px) {
  const Error damaged{ErrorCode::kCorrupt,
                      "the memory of the map is damaged; delete mosaic.state and start again", ""};
  if (packed.empty()) return damaged;
  const std::vector<std::uint8_t> bytes(packed.begin(), packed.end());
  cv::Mat bgra;
  try {
    bgra = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return damaged;
  }
  if (bgra.cols != side_px || bgra.rows != side_px || bgra.type() != CV_8UC4) return damaged;
  RgbaImage picture = RgbaImage::Transparent(side_px, side_px);
  cv::cvtColor(bgra, cv::Mat(side_px, side_px, CV_8UC4, picture.rgba.data()), cv::COLOR_BGRA2RGBA);
  return picture;
}

}  // namespace skyquilt::pyramid
