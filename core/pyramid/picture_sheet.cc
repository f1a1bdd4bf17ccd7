#include "core/pyramid/picture_sheet.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace skyquilt::pyramid {
namespace {

constexpr int kGapPx = 8;
constexpr int kCaptionPx = 26;
constexpr double kFontScale = 0.5;

}  // namespace

image::RgbaImage PictureSheet(const std::vector<SheetPicture>& pictures, int columns) {
  SKYQUILT_CHECK(!pictures.empty() && columns > 0, "a sheet needs pictures and columns");
  int width = 0, height = 0;
  for (const SheetPicture& picture : pictures) {
    width = std::max(width, picture.image.width_px);
    height = std::max(height, picture.image.height_px);
  }
  const int rows = (static_cast<int>(pictures.size()) + columns - 1) / columns;
  const int cell_width = width + kGapPx, cell_height = height + kCaptionPx + kGapPx;
  image::RgbaImage sheet{kGapPx + columns * cell_width, kGapPx + rows * cell_height, {}};
  sheet.rgba.assign(static_cast<std::size_t>(sheet.width_px) * sheet.height_px * 4, 255);
  cv::Mat canvas(sheet.height_px, sheet.width_px, CV_8UC4, sheet.rgba.data());
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const int x0 = kGapPx + static_cast<int>(k) % columns * cell_width;
    const int y0 = kGapPx + static_cast<int>(k) / columns * cell_height;
    cv::putText(canvas, pictures[k].caption, {x0, y0 + kCaptionPx - 9}, cv::FONT_HERSHEY_SIMPLEX, kFontScale,
                cv::Scalar(0, 0, 0, 255), 1, cv::LINE_AA);
    const image::RgbaImage& image = pictures[k].image;
    for (int y = 0; y < image.height_px; ++y) {
      for (int x = 0; x < image.width_px; ++x) {
        const std::uint8_t* from = image.Pixel(x, y);
        std::uint8_t* to = sheet.Pixel(x0 + x, y0 + kCaptionPx + y);
        // Premultiplied, on white.
        for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint8_t>(from[c] + 255 - from[3]);
      }
    }
  }
  return sheet;
}

}  // namespace skyquilt::pyramid
