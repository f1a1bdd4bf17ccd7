// The features of core/alignment/features beside cv::SIFT's, on pairs of views whose geometry is known
// exactly: a photo, shrunk to the detector's 1.5 megapixels, and the same photo seen anew (turned any way,
// tilted, nearer or farther, in other light, with noise). Both kinds are matched by MatchDescriptors;
// descriptors of cv::SIFT are made RootSIFT first, and its places freed of the quarter pixel by which its
// doubled image is shifted.
//   features_against_sift FOLDER [SEEDS a photo]
// Deterministic but for the times, which are processor time of one thread.
#include <fmt/core.h>

#include <Eigen/Dense>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/alignment/estimators/epipolar.h"
#include "core/alignment/features/features.h"
#include "core/alignment/matching/match_descriptors.h"
#include "core/alignment/scene/keypoints.h"
#include "core/base/median.h"
#include "tests/bench/libraries/measure.h"

namespace skyquilt::alignment {
namespace {

constexpr int kMaxFeatures = 2000;
constexpr double kPixels = 1.5e6;
constexpr double kRightPx = 3.0;  // a match that misses its true place by less

using Eigen::Matrix3d;
using Eigen::Vector2d;

struct Views {
  cv::Mat first, second;  // grey
  Matrix3d second_from_first = Matrix3d::Identity();
};

cv::Mat InOtherLight(const cv::Mat& grey, double gain, double gamma, double noise, int seed) {
  cv::Mat image, grain(grey.size(), CV_32F), out;
  grey.convertTo(image, CV_32F, 1.0 / 255.0);
  cv::pow(image, gamma, image);
  cv::RNG random(static_cast<std::uint64_t>(seed) + 77);
  random.fill(grain, cv::RNG::NORMAL, 0.0, noise);
  image = 255.0 * gain * image + grain;
  image.convertTo(out, CV_8U);
  return out;
}

// Pixel centres: what shrinks by `scale` maps x to (x + 0.5) scale - 0.5.
Matrix3d Scaling(double x, double y) {
  Matrix3d scaling;
  scaling << x, 0.0, 0.5 * x - 0.5, 0.0, y, 0.5 * y - 0.5, 0.0, 0.0, 1.0;
  return scaling;
}

Views ViewsOf(const cv::Mat& photo, int seed) {
  const double shrink = std::min(1.0, std::sqrt(kPixels / static_cast<double>(photo.total())));
  const cv::Size size(cvRound(photo.cols * shrink), cvRound(photo.rows * shrink));
  Views views;
  cv::Mat small;
  cv::resize(photo, small, size, 0, 0, cv::INTER_AREA);
  views.first = InOtherLight(small, 1.0, 1.0, 2.0, 2 * seed);
  Sampler sampler(static_cast<std::uint64_t>(seed));
  const auto between = [&](double low, double high) { return low + (high - low) * Uniform(sampler); };
  const double turn = between(-std::numbers::pi, std::numbers::pi), scale = between(0.8, 1.25);
  const double cx = 0.5 * size.width, cy = 0.5 * size.height;
  Matrix3d to_middle = Matrix3d::Identity(), from_middle = Matrix3d::Identity(), moved;
  to_middle.topRightCorner<2, 1>() << -cx, -cy;
  from_middle.topRightCorner<2, 1>() << cx + between(-0.15, 0.15) * size.width,
      cy + between(-0.15, 0.15) * size.height;
  moved << scale * std::cos(turn), -scale * std::sin(turn), 0.0, scale * std::sin(turn),
      scale * std::cos(turn), 0.0, between(-0.25, 0.25) / size.width, between(-0.25, 0.25) / size.height, 1.0;
  views.second_from_first = from_middle * moved * to_middle;
  // From the whole photo, at twice the size and then averaged, so that nothing aliases.
  const Matrix3d first_from_photo =
      Scaling(static_cast<double>(size.width) / photo.cols, static_cast<double>(size.height) / photo.rows);
  const Matrix3d doubled_from_photo = Scaling(2.0, 2.0) * views.second_from_first * first_from_photo;
  cv::Mat map(3, 3, CV_64F), doubled, second;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) map.at<double>(r, c) = doubled_from_photo(r, c);
  }
  cv::warpPerspective(photo, doubled, map, size * 2, cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::mean(photo));
  cv::resize(doubled, second, size, 0, 0, cv::INTER_AREA);
  views.second = InOtherLight(second, between(0.75, 1.2), between(0.8, 1.25), 3.0, 2 * seed + 1);
  return views;
}

// Of the picture at `size` times its own; places in the picture's own pixels.
PhotoFeatures Ours(const cv::Mat& whole, double size) {
  cv::Mat grey = whole;
  if (size != 1.0) cv::resize(whole, grey, {}, size, size, cv::INTER_LINEAR);
  flight::Photo photo;
  photo.name = "view";
  photo.intrinsics = camera::Intrinsics::Centered(whole.cols, whole.rows, whole.cols);
  image::DecodedImage decoded{grey.cols, grey.rows, {}};
  decoded.rgb.resize(grey.total() * 3);
  cv::Mat rgb(grey.rows, grey.cols, CV_8UC3, decoded.rgb.data());
  cv::cvtColor(grey, rgb, cv::COLOR_GRAY2RGB);
  return FeaturesOf(photo, decoded, static_cast<int>(grey.total())).value();
}

PhotoFeatures Sift(const cv::Mat& whole, bool halved) {
  cv::Mat grey = whole;
  if (halved) cv::resize(whole, grey, {}, 0.5, 0.5, cv::INTER_AREA);
  const double scale = halved ? 2.0 : 1.0;
  std::vector<cv::KeyPoint> found;
  cv::Mat described;
  cv::SIFT::create(kMaxFeatures)->detectAndCompute(grey, cv::noArray(), found, described);
  PhotoFeatures features;
  features.sigma_px = 0.35;
  const int count = std::min(kMaxFeatures, static_cast<int>(found.size()));
  for (int k = 0; k < count; ++k) {
    const cv::KeyPoint& point = found[static_cast<std::size_t>(k)];
    features.keypoints.push_back({.x_px = static_cast<float>((point.pt.x - 0.25 + 0.5) * scale - 0.5),
                                  .y_px = static_cast<float>((point.pt.y - 0.25 + 0.5) * scale - 0.5),
                                  .angle_rad = static_cast<float>(point.angle * std::numbers::pi / 180.0),
                                  .scale_px = static_cast<float>(point.size * scale)});
    const float* bins = described.ptr<float>(k);
    float sum = 1e-9F;
    for (int b = 0; b < kDescriptorSize; ++b) sum += bins[b];
    Descriptor packed{};
    for (int b = 0; b < kDescriptorSize; ++b) {
      packed[static_cast<std::size_t>(b)] =
          static_cast<std::uint8_t>(std::min(255.0F, 512.0F * std::sqrt(bins[b] / sum) + 0.5F));
    }
    features.descriptors.push_back(packed);
  }
  return features;
}

struct Tally {
  std::vector<double> seconds_a_megapixel, matches, right, share, errors_px, ce90_px, map_px;
  int failed = 0;
};

Vector2d PlaceOf(const Keypoint& point) { return {point.x_px, point.y_px}; }

void Judge(const Views& views, const std::function<PhotoFeatures(const cv::Mat&)>& find, Tally& tally) {
  const double start = ThreadSeconds();
  const PhotoFeatures first = find(views.first), second = find(views.second);
  tally.seconds_a_megapixel.push_back(1e6 * (ThreadSeconds() - start) /
                                      (2.0 * static_cast<double>(views.first.total())));
  const std::vector<KeypointMatch> matches = MatchDescriptors(first, second, kMaxFeatures);
  std::vector<double> errors;
  std::vector<RayPair> pairs;
  for (const KeypointMatch& match : matches) {
    pairs.push_back({PlaceOf(first.keypoints[static_cast<std::size_t>(match.first)]),
                     PlaceOf(second.keypoints[static_cast<std::size_t>(match.second)])});
    const RayPair& pair = pairs.back();
    const double error =
        ((views.second_from_first * pair.first.homogeneous()).hnormalized() - pair.second).norm();
    if (error < kRightPx) {
      errors.push_back(error);
    } else {
      pairs.pop_back();
    }
  }
  tally.matches.push_back(static_cast<double>(matches.size()));
  tally.right.push_back(static_cast<double>(errors.size()));
  tally.share.push_back(
      matches.empty() ? 0.0 : static_cast<double>(errors.size()) / static_cast<double>(matches.size()));
  // What the right ones say together.
  const std::optional<Matrix3d> fit = FitHomography(pairs);
  if (!fit) {
    ++tally.failed;
    return;
  }
  tally.ce90_px.push_back(Quantile(errors, 0.9));
  tally.errors_px.push_back(Median(std::move(errors)));
  std::vector<double> over_picture;
  for (int y = 0; y <= 8; ++y) {
    for (int x = 0; x <= 8; ++x) {
      const Eigen::Vector3d at(x * (views.first.cols - 1) / 8.0, y * (views.first.rows - 1) / 8.0, 1.0);
      over_picture.push_back(
          ((*fit * at).hnormalized() - (views.second_from_first * at).hnormalized()).norm());
    }
  }
  tally.map_px.push_back(Quantile(std::move(over_picture), 0.9));
}

}  // namespace
}  // namespace skyquilt::alignment

int main(int argc, char** argv) {
  using namespace skyquilt;
  using namespace skyquilt::alignment;
  if (argc < 2) {
    fmt::print(stderr, "usage: {} FOLDER [SEEDS]\n", argv[0]);
    return 2;
  }
  cv::setNumThreads(1);
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 5;
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  const std::vector<std::pair<std::string, std::function<PhotoFeatures(const cv::Mat&)>>> finders = {
      {"ours", [](const cv::Mat& grey) { return Ours(grey, 1.0); }},
      {"ours on twice the size", [](const cv::Mat& grey) { return Ours(grey, 2.0); }},
      {"cv::SIFT (doubles the size)", [](const cv::Mat& grey) { return Sift(grey, false); }},
      {"cv::SIFT on half the size", [](const cv::Mat& grey) { return Sift(grey, true); }}};
  std::vector<Tally> tallies(finders.size());
  int views_made = 0;
  constexpr std::size_t kPhotos = 4;
  for (std::size_t k = 0; k < std::min(kPhotos, files.size()); ++k) {
    const cv::Mat photo = cv::imread(files[k * files.size() / kPhotos], cv::IMREAD_GRAYSCALE);
    if (photo.empty()) continue;
    for (int seed = 0; seed < seeds; ++seed) {
      const Views views = ViewsOf(photo, ++views_made);
      for (std::size_t f = 0; f < finders.size(); ++f) Judge(views, finders[f].second, tallies[f]);
    }
  }
  if (views_made == 0) {
    fmt::print(stderr, "{} holds no photo that can be read.\n", argv[1]);
    return 1;
  }
  fmt::print("{} pairs of views; medians over the pairs, pixels of the {:.1f}-megapixel view\n", views_made,
             1e-6 * kPixels);
  fmt::print("{:28} {:>8} {:>8} {:>8} {:>7} {:>9} {:>8} {:>15} {:>6}\n", "", "ms/MP", "matches", "right",
             "share", "median px", "CE90 px", "fitted CE90 px", "failed");
  for (std::size_t f = 0; f < finders.size(); ++f) {
    const Tally& tally = tallies[f];
    fmt::print("{:28} {:8.1f} {:8.0f} {:8.0f} {:6.1f}% {:9.3f} {:8.3f} {:15.3f} {:6}\n", finders[f].first,
               1e3 * Median(tally.seconds_a_megapixel), Median(tally.matches), Median(tally.right),
               100.0 * Median(tally.share), MedianIfAny(tally.errors_px).value_or(0.0),
               MedianIfAny(tally.ce90_px).value_or(0.0), MedianIfAny(tally.map_px).value_or(0.0),
               tally.failed);
  }
  return 0;
}
