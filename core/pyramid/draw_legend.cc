#include "core/pyramid/draw_legend.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace skyquilt::pyramid {
namespace {

constexpr int kMinLegendWidthPx = 80, kMinLegendHeightPx = 56;
constexpr int kLegendMarginPx = 16, kTitleBasePx = 17, kBarTopPx = 25, kBarHeightPx = 14, kMarksBasePx = 54;
constexpr double kTitleScale = 0.45, kMarkScale = 0.38;
const cv::Scalar kInk(0x22, 0x22, 0x22, 0xff), kLine(0x77, 0x77, 0x77, 0xff);

int WidthOf(const std::string& text, double scale) {
  int base = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &base).width;
}

std::string FittedTitle(std::string title, int width_px) {
  constexpr std::size_t kMaxTitleCharacters = 200;  // more than fit on any legend
  title.resize(std::min(title.size(), kMaxTitleCharacters));
  if (WidthOf(title, kTitleScale) <= width_px) return title;
  while (!title.empty() && WidthOf(title + "...", kTitleScale) > width_px) title.pop_back();
  return title + "...";
}

}  // namespace

image::RgbaImage DrawLegend(const Legend& legend, int width_px, int height_px) {
  SKYQUILT_CHECK(width_px >= kMinLegendWidthPx && height_px >= kMinLegendHeightPx, "no room for a legend");
  SKYQUILT_CHECK(!legend.colours.empty(), "a legend without colours");
  image::RgbaImage card = image::RgbaImage::Transparent(width_px, height_px);
  cv::Mat canvas(height_px, width_px, CV_8UC4, card.rgba.data());
  canvas.setTo(cv::Scalar::all(255));
  cv::rectangle(canvas, {0, 0, width_px, height_px}, kLine);
  const int bar_px = width_px - 2 * kLegendMarginPx;
  cv::putText(canvas, FittedTitle(legend.title, bar_px), {kLegendMarginPx, kTitleBasePx},
              cv::FONT_HERSHEY_SIMPLEX, kTitleScale, kInk, 1, cv::LINE_AA);
  const std::size_t colours = legend.colours.size();
  for (int x = 0; x < bar_px; ++x) {
    const auto last = static_cast<std::size_t>(bar_px - 1);
    const std::size_t at = (static_cast<std::size_t>(x) * (colours - 1) + last / 2) / last;
    for (int y = kBarTopPx; y < kBarTopPx + kBarHeightPx; ++y)
      std::copy(legend.colours[at].begin(), legend.colours[at].end(), card.Pixel(kLegendMarginPx + x, y));
  }
  cv::rectangle(canvas, {kLegendMarginPx - 1, kBarTopPx - 1, bar_px + 2, kBarHeightPx + 2}, kLine);
  const auto marks = static_cast<int>(legend.marks.size());
  for (int i = 0; i < marks; ++i) {
    const std::string& mark = legend.marks[static_cast<std::size_t>(i)];
    const int middle = kLegendMarginPx + (marks > 1 ? i * (bar_px - 1) / (marks - 1) : 0);
    const int width = WidthOf(mark, kMarkScale);
    const int left = std::clamp(middle - width / 2, 2, std::max(2, width_px - width - 2));
    cv::putText(canvas, mark, {left, kMarksBasePx}, cv::FONT_HERSHEY_SIMPLEX, kMarkScale, kInk, 1,
                cv::LINE_AA);
  }
  return card;
}

}  // namespace skyquilt::pyramid
