#include "tests/core/video/moving_film.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

namespace skyquilt::video {
namespace {

cv::Mat Ground(int width_px) {
  cv::Mat ground(kFilmHeightPx, width_px, CV_8UC3);
  cv::RNG random(11);
  random.fill(ground, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(ground, ground, cv::Size(), 5.0);
  cv::normalize(ground, ground, 0, 255, cv::NORM_MINMAX);
  return ground;
}

}  // namespace

bool WriteFilm(const std::filesystem::path& path, int frames, const std::function<int(int)>& left_px) {
  int right = 0;
  for (int k = 0; k < frames; ++k) right = std::max(right, left_px(k) + kFilmWidthPx);
  const cv::Mat ground = Ground(right);
  cv::VideoWriter writer(path.string(), cv::VideoWriter::fourcc('m', 'p', '4', 'v'), kFilmFramesPerS,
                         cv::Size(kFilmWidthPx, kFilmHeightPx));
  if (!writer.isOpened()) return false;
  for (int k = 0; k < frames; ++k) {
    // A copy: OpenCV's writer reads past the end of a part of a picture.
    writer.write(ground(cv::Rect(left_px(k), 0, kFilmWidthPx, kFilmHeightPx)).clone());
  }
  return true;
}

}  // namespace skyquilt::video
