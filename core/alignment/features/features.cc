#include "core/alignment/features/features.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <utility>

#include "core/alignment/features/describe_point.h"
#include "core/alignment/features/scale_space.h"
#include "core/alignment/features/sharpness.h"
#include "core/base/parallel_for.h"
#include "core/base/scoped_timer.h"
#include "core/base/try.h"
#include "core/image/shrink/shrink_picture.h"

namespace skyquilt::alignment {
namespace {

constexpr float kContrast = 1.7F;  // grey levels
constexpr float kLowContrast = 0.7F;
constexpr double kLocatedTo = 0.35;  // pixels of the detector's image
// Finer, noise counts as detail.
constexpr int kSharpnessPixels = 375'000;
constexpr int kSharpnessShrink = 4;  // of the detector's pixels, at least
constexpr int kFewFeatures = 500;
constexpr int kCellsAcross = 16;

// Keeps in each cell of the image its strongest spots, and orders all by their rank inside the cell.
std::vector<ScalePoint> Spread(const std::vector<Octave>& octaves, std::vector<ScalePoint> found,
                               int width_px, int height_px) {
  const auto stronger = [](const ScalePoint& a, const ScalePoint& b) {
    return std::tie(b.contrast, a.octave, a.y_px, a.x_px, a.blur_px) <
           std::tie(a.contrast, b.octave, b.y_px, b.x_px, b.blur_px);
  };
  std::sort(found.begin(), found.end(), stronger);
  const float cell_px = static_cast<float>(width_px) / kCellsAcross;
  const int rows = static_cast<int>(static_cast<float>(height_px) / cell_px) + 1;
  std::vector<int> taken(static_cast<std::size_t>(kCellsAcross + 1) * (rows + 1), 0);
  std::vector<std::pair<int, int>> ranked;  // rank in its cell, index by strength
  ranked.reserve(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto step = static_cast<float>(octaves[found[i].octave].step_px);
    const int column = std::clamp(static_cast<int>(found[i].x_px * step / cell_px), 0, kCellsAcross);
    const int row = std::clamp(static_cast<int>(found[i].y_px * step / cell_px), 0, rows);
    ranked.emplace_back(taken[row * (kCellsAcross + 1) + column]++, static_cast<int>(i));
  }
  std::sort(ranked.begin(), ranked.end());
  if (static_cast<int>(ranked.size()) > kMaxFoundKeypoints) ranked.resize(kMaxFoundKeypoints);
  std::vector<ScalePoint> kept;
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

cv::Mat Shrunk(const cv::Mat& grey, double scale) {
  cv::Mat smaller(std::max(1, cvRound(grey.rows * scale)), std::max(1, cvRound(grey.cols * scale)), CV_8U);
  image::ShrinkByArea({grey.data, grey.cols, grey.rows, 1, grey.step}, smaller.cols, smaller.rows,
                      smaller.data);
  return smaller;
}

Thumbnail MakeThumbnail(const cv::Mat& grey) {
  constexpr double kLongerPx = 256.0;
  const cv::Mat small = Shrunk(grey, std::min(1.0, kLongerPx / std::max(grey.cols, grey.rows)));
  return {small.cols, small.rows, {small.data, small.data + small.total()}};
}

cv::Mat AtMost(const cv::Mat& grey, int pixels) {
  const double shrink = std::sqrt(static_cast<double>(pixels) / static_cast<double>(grey.total()));
  return shrink >= 0.98 ? grey : Shrunk(grey, shrink);
}

void Detect(const cv::Mat& grey, const flight::Photo& photo, int detector_pixels, PhotoFeatures& features) {
  ScopedTimer timer(features.detect_s);
  cv::Mat image = AtMost(grey, detector_pixels);
  const cv::Mat small =
      AtMost(image, std::min(kSharpnessPixels, static_cast<int>(image.total()) / kSharpnessShrink));
  features.detail = MeasureDetail(small.cols, small.rows, small.data);
  features.thumbnail = MakeThumbnail(grey);
  std::vector<Octave> octaves = BuildScaleSpace(image.cols, image.rows, image.data);
  std::vector<ScalePoint> found = FindScalePoints(octaves, kContrast);
  if (static_cast<int>(found.size()) < kFewFeatures) {
    image = EvenContrast(image);
    octaves = BuildScaleSpace(image.cols, image.rows, image.data);
    found = FindScalePoints(octaves, kLowContrast);
  }
  const double full_per_x = static_cast<double>(photo.intrinsics.width_px) / image.cols;
  const double full_per_y = static_cast<double>(photo.intrinsics.height_px) / image.rows;
  for (const ScalePoint& point : Spread(octaves, std::move(found), image.cols, image.rows)) {
    const Octave& octave = octaves[point.octave];
    const BlurredImage& layer = octave.layers[point.layer];
    for (const float direction_rad : DirectionsOf(layer, point)) {
      if (static_cast<int>(features.keypoints.size()) == kMaxFoundKeypoints) break;
      const auto step = static_cast<double>(octave.step_px);
      features.keypoints.push_back({.x_px = static_cast<float>((point.x_px * step + 0.5) * full_per_x - 0.5),
                                    .y_px = static_cast<float>((point.y_px * step + 0.5) * full_per_y - 0.5),
                                    .angle_rad = direction_rad,
                                    .scale_px = static_cast<float>(2.0 * point.blur_px * step * full_per_x)});
      features.descriptors.push_back(Describe(layer, point, direction_rad));
    }
  }
  features.sigma_px = kLocatedTo * full_per_x;
}

}  // namespace

// The smallest size that still holds the pixels; JPEG decoders scale by these for almost nothing.
int DenominatorOf(const flight::Photo& photo) {
  for (int denominator = 8; denominator > 1; denominator /= 2) {
    const double kept = static_cast<double>(photo.intrinsics.width_px) * photo.intrinsics.height_px /
                        (denominator * denominator);
    if (kept >= kDetectorPixels) return denominator;
  }
  return 1;
}

Result<PhotoFeatures> FeaturesOf(const flight::Photo& photo, const image::DecodedImage& decoded,
                                 int detector_pixels) {
  if (decoded.width_px < 16 || decoded.height_px < 16) {
    return Error{ErrorCode::kCorrupt, "The picture of " + photo.name + " is smaller than 16 pixels.", ""};
  }
  PhotoFeatures features;
  const cv::Mat rgb(decoded.height_px, decoded.width_px, CV_8UC3,
                    const_cast<std::uint8_t*>(decoded.rgb.data()));
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  Detect(grey, photo, detector_pixels, features);
  return features;
}

Result<PhotoFeatures> ExtractFeatures(const flight::Photo& photo, const flight::PhotoSource& source) {
  double decode_s = 0.0;
  SKYQUILT_TRY_ASSIGN(const image::DecodedImage decoded, [&] {
    ScopedTimer timer(decode_s);
    return source.Decode(photo, DenominatorOf(photo));
  }());
  Result<PhotoFeatures> features = FeaturesOf(photo, decoded);
  if (features) features->decode_s = decode_s;
  return features;
}

std::vector<PhotoFeatures> ExtractAll(const poses::PosedFlight& posed, const flight::PhotoSource& source,
                                      FoundFeatures found, int threads, double last_fraction,
                                      Progress& progress) {
  const std::size_t count = posed.photos.size();
  std::vector<PhotoFeatures> extracted(count);
  std::atomic<std::size_t> done{0};
  ParallelFor(count, threads, [&](std::size_t i) {
    if (progress.IsCancelled()) return;
    const flight::Photo& photo = posed.photos[i].photo;
    const auto known = found.find(photo.name);
    Result<PhotoFeatures> features =
        known != found.end() ? std::move(known->second) : ExtractFeatures(photo, source);
    if (features) {
      extracted[i] = *std::move(features);
    } else {
      extracted[i].unreadable = features.error().message;
    }
    progress.Report(last_fraction * static_cast<double>(++done) / static_cast<double>(count),
                    "finding features");
  });
  return extracted;
}

}  // namespace skyquilt::alignment
