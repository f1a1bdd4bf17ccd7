// ShrinkByArea (core/image/shrink) beside cv::resize with INTER_AREA, from the half of a photo of nine
// megapixels to what is made of each photo: the picture in which features are found, its small grey picture
// and its thumbnail in colour.
//   shrink_against_opencv [TIMES]
// Deterministic but for the times, which are processor time of one thread, the median.
#include <fmt/core.h>

#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "core/base/median.h"
#include "core/image/shrink/shrink_picture.h"
#include "tests/bench/libraries/measure.h"

namespace skyquilt::image {
namespace {

void Compare(const char* name, const cv::Mat& picture, const cv::Size& to, int times) {
  std::vector<double> theirs_ms, ours_ms;
  cv::Mat theirs, ours(to, picture.type());
  for (int k = 0; k < times; ++k) {
    const double start_s = alignment::ThreadSeconds();
    cv::resize(picture, theirs, to, 0, 0, cv::INTER_AREA);
    const double middle_s = alignment::ThreadSeconds();
    ShrinkByArea({picture.data, picture.cols, picture.rows, picture.channels(), picture.step}, to.width,
                 to.height, ours.data);
    theirs_ms.push_back(1e3 * (middle_s - start_s));
    ours_ms.push_back(1e3 * (alignment::ThreadSeconds() - middle_s));
  }
  fmt::print("{:<34} cv::resize {:5.2f} ms, ShrinkByArea {:5.2f} ms, {:.0f} level apart at most\n", name,
             Median(theirs_ms), Median(ours_ms), cv::norm(theirs, ours, cv::NORM_INF));
}

}  // namespace
}  // namespace skyquilt::image

int main(int count, char** arguments) {
  using skyquilt::image::Compare;
  const int times = count > 1 ? std::atoi(arguments[1]) : 11;
  cv::setNumThreads(1);
  std::mt19937 random(1);
  cv::Mat rgb(1125, 2000, CV_8UC3);
  for (std::size_t i = 0; i < 3 * rgb.total(); ++i) rgb.data[i] = static_cast<std::uint8_t>(random() % 256);
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  Compare("grey, 1.5 megapixels", grey, {1633, 919}, times);
  Compare("grey, 256 pixels", grey, {256, 144}, times);
  Compare("colour, 384 pixels", rgb, {384, 216}, times);
  return 0;
}
