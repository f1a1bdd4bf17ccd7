#include "core/alignment/features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/scoped_timer.h"

namespace skyquilt::alignment {
namespace {

constexpr int kOctaveLayers = 3;
constexpr double kContrast = 0.02;
constexpr double kLowContrast = 0.008;
constexpr double kEdge = 12.0;
constexpr double kFirstSigma = 1.6;
constexpr int kFewFeatures = 500;
constexpr int kCellsAcross = 16;
constexpr int kMostDetected = 12'000;

// The smallest size that still holds `pixels`; JPEG decoders scale by these for almost nothing.
int Denominator(const flight::Photo& photo, int pixels) {
  for (int denominator = 8; denominator > 1; denominator /= 2) {
    const double kept = static_cast<double>(photo.intrinsics.width_px) * photo.intrinsics.height_px /
                        (denominator * denominator);
    if (kept >= pixels) return denominator;
  }
  return 1;
}

// Detects; keeps in each cell of the photo its strongest, and orders all by their rank inside the cell.
std::vector<cv::KeyPoint> DetectSpread(const cv::Mat& image, double contrast, int max_features) {
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(kMostDetected, kOctaveLayers, contrast, kEdge, kFirstSigma);
  std::vector<cv::KeyPoint> found;
  sift->detect(image, found);
  const auto stronger = [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    if (a.response != b.response) return a.response > b.response;
    if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
    if (a.pt.x != b.pt.x) return a.pt.x < b.pt.x;
    if (a.size != b.size) return a.size < b.size;
    return a.angle < b.angle;
  };
  std::sort(found.begin(), found.end(), stronger);
  const double cell_px = static_cast<double>(image.cols) / kCellsAcross;
  const int rows = static_cast<int>(image.rows / cell_px) + 1;
  std::vector<int> taken(static_cast<std::size_t>(kCellsAcross + 1) * (rows + 1), 0);
  std::vector<std::pair<int, int>> ranked;  // rank in its cell, index by strength
  ranked.reserve(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const int column = std::clamp(static_cast<int>(found[i].pt.x / cell_px), 0, kCellsAcross);
    const int row = std::clamp(static_cast<int>(found[i].pt.y / cell_px), 0, rows);
    ranked.emplace_back(taken[static_cast<std::size_t>(row) * (kCellsAcross + 1) + column]++,
                        static_cast<int>(i));
  }
  std::sort(ranked.begin(), ranked.end());
  if (static_cast<int>(ranked.size()) > max_features) ranked.resize(max_features);
  std::vector<cv::KeyPoint> kept;
  kept.reserve(ranked.size());
  for (const auto& [rank, index] : ranked) kept.push_back(found[index]);
  return kept;
}

// Evens out light and contrast, so that bare ground shows its grain.
cv::Mat EvenContrast(const cv::Mat& grey) {
  cv::Mat image, mean, square, deviation;
  grey.convertTo(image, CV_32F);
  const double sigma = std::max(grey.cols, grey.rows) / 40.0;
  cv::GaussianBlur(image, mean, {}, sigma);
  image -= mean;
  square = image.mul(image);
  cv::GaussianBlur(square, deviation, {}, sigma);
  cv::sqrt(deviation, deviation);
  deviation += 1.5;  // grey levels of noise: do not blow up what is not there
  image = 128.0 + 45.0 * (image / deviation);
  cv::Mat even;
  image.convertTo(even, CV_8U);
  return even;
}

Descriptor Pack(const float* sift) {
  double sum = 1e-9;
  for (int k = 0; k < 128; ++k) sum += sift[k];
  Descriptor packed;
  for (int k = 0; k < 128; ++k) {
    packed[k] = static_cast<std::uint8_t>(std::min(255.0, 512.0 * std::sqrt(sift[k] / sum) + 0.5));
  }
  return packed;
}

Thumbnail MakeThumbnail(const cv::Mat& grey, int longer_px) {
  const double scale = std::min(1.0, static_cast<double>(longer_px) / std::max(grey.cols, grey.rows));
  cv::Mat small;
  cv::resize(grey, small,
             cv::Size(std::max(1, cvRound(grey.cols * scale)), std::max(1, cvRound(grey.rows * scale))), 0, 0,
             cv::INTER_AREA);
  Thumbnail thumbnail{small.cols, small.rows, {}};
  thumbnail.grey.assign(small.data, small.data + small.total());
  return thumbnail;
}

// Of the direction in which the picture is least sharp: motion blurs one direction alone. The energy of the
// second derivative along (c, s), c^2 xx + 2 c s xy + s^2 yy, follows from five moments.
double Sharpness(const cv::Mat& grey) {
  constexpr int kDirections = 36;
  cv::Mat xx, xy, yy;
  cv::Sobel(grey, xx, CV_32F, 2, 0);
  cv::Sobel(grey, xy, CV_32F, 1, 1);
  cv::Sobel(grey, yy, CV_32F, 0, 2);
  const double moments[] = {xx.dot(xx), 4.0 * xx.dot(xy), 4.0 * xy.dot(xy) + 2.0 * xx.dot(yy),
                            4.0 * xy.dot(yy), yy.dot(yy)};
  double least = std::numeric_limits<double>::max();
  for (int k = 0; k < kDirections; ++k) {
    const double c = std::cos(CV_PI * k / kDirections);
    const double s = std::sin(CV_PI * k / kDirections);
    least =
        std::min(least, moments[0] * c * c * c * c + moments[1] * c * c * c * s + moments[2] * c * c * s * s +
                            moments[3] * c * s * s * s + moments[4] * s * s * s * s);
  }
  cv::Scalar mean, of_picture;
  cv::meanStdDev(grey, mean, of_picture);
  return least / static_cast<double>(grey.total()) / (of_picture[0] * of_picture[0] + 1.0);
}

void Describe(const cv::Mat& grey, const flight::Photo& photo, const FeatureOptions& options,
              PhotoFeatures& features) {
  ScopedTimer timer(features.detect_s);
  features.thumbnail = MakeThumbnail(grey, options.thumbnail_px);
  if (options.max_features == 0) return;
  const double shrink = std::min(
      1.0, std::sqrt(static_cast<double>(options.detector_pixels) / static_cast<double>(grey.total())));
  cv::Mat image = grey;
  if (shrink < 0.98) {
    cv::resize(grey, image, cv::Size(cvRound(grey.cols * shrink), cvRound(grey.rows * shrink)), 0, 0,
               cv::INTER_AREA);
  }
  features.sharpness = Sharpness(image);
  std::vector<cv::KeyPoint> kept = DetectSpread(image, kContrast, options.max_features);
  if (static_cast<int>(kept.size()) < kFewFeatures) {
    image = EvenContrast(image);
    kept = DetectSpread(image, kLowContrast, options.max_features);
  }
  cv::Mat descriptors;
  if (!kept.empty()) {
    cv::SIFT::create(0, kOctaveLayers, kContrast, kEdge, kFirstSigma)->compute(image, kept, descriptors);
  }
  const double full_per_x = static_cast<double>(photo.intrinsics.width_px) / image.cols;
  const double full_per_y = static_cast<double>(photo.intrinsics.height_px) / image.rows;
  features.keypoints.reserve(kept.size());
  features.descriptors.reserve(kept.size());
  // The detector halves coordinates of its doubled image without the quarter pixel between the two grids.
  constexpr double kDoublingShift = 0.25;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const cv::KeyPoint& point = kept[i];
    features.keypoints.push_back(
        {.x_px = static_cast<float>((point.pt.x - kDoublingShift + 0.5) * full_per_x - 0.5),
         .y_px = static_cast<float>((point.pt.y - kDoublingShift + 0.5) * full_per_y - 0.5),
         .angle_rad = static_cast<float>(point.angle * (CV_PI / 180.0)),
         .scale_px = static_cast<float>(point.size * full_per_x),
         .response = point.response});
    features.descriptors.push_back(Pack(descriptors.ptr<float>(static_cast<int>(i))));
  }
  features.sigma_px = 0.35 * 0.5 * full_per_x;
}

}  // namespace

Result<PhotoFeatures> ExtractFeatures(const flight::Photo& photo, const pipeline::PhotoSource& source,
                                      const FeatureOptions& options) {
  PhotoFeatures features;
  cv::Mat grey;
  {
    ScopedTimer timer(features.decode_s);
    Result<pipeline::DecodedImage> decoded =
        source.Decode(photo, Denominator(photo, options.detector_pixels));
    if (!decoded) return decoded.error();
    if (decoded->width_px < 16 || decoded->height_px < 16) {
      return Error{ErrorCode::kCorrupt, "the picture of " + photo.name + " is smaller than 16 pixels", ""};
    }
    const cv::Mat rgb(decoded->height_px, decoded->width_px, CV_8UC3, decoded->rgb.data());
    cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  }
  Describe(grey, photo, options, features);
  return features;
}

}  // namespace skyquilt::alignment
