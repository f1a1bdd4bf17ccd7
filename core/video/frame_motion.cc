#include "core/video/frame_motion.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

namespace skyquilt::video {
namespace {

constexpr int kMaxCorners = 300, kMinFollowed = 20;
constexpr double kCornerQuality = 0.01, kCornerDistancePx = 8.0, kTolerancePx = 2.0;
constexpr int kGridSide = 24;  // points of a frame that are looked for in the reference

cv::Mat AsMat(const GrayFrame& frame) {
  return cv::Mat(frame.height_px, frame.width_px, CV_8UC1, const_cast<std::uint8_t*>(frame.gray.data()));
}

// From a frame's pixels to the reference's.
using Motion = cv::Matx33d;

std::optional<Motion> MotionBetween(const cv::Mat& before, const cv::Mat& now) {
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(before, corners, kMaxCorners, kCornerQuality, kCornerDistancePx);
  if (static_cast<int>(corners.size()) < kMinFollowed) return std::nullopt;
  std::vector<cv::Point2f> followed;
  std::vector<unsigned char> is_found;
  cv::calcOpticalFlowPyrLK(before, now, corners, followed, is_found, cv::noArray(), cv::Size(21, 21), 4);
  std::vector<cv::Point2f> from, to;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (is_found[i] == 0) continue;
    from.push_back(followed[i]);
    to.push_back(corners[i]);
  }
  if (static_cast<int>(from.size()) < kMinFollowed) return std::nullopt;
  std::vector<unsigned char> fits;
  const cv::Mat similarity = cv::estimateAffinePartial2D(from, to, fits, cv::RANSAC, kTolerancePx);
  if (similarity.empty() || std::count(fits.begin(), fits.end(), 1) < kMinFollowed) return std::nullopt;
  Motion motion = Motion::eye();
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) motion(row, column) = similarity.at<double>(row, column);
  }
  return motion;
}

// The share of a frame that the reference shows too.
double Overlap(const Motion& reference_from_frame, const cv::Size& size) {
  int inside = 0;
  for (int i = 0; i < kGridSide * kGridSide; ++i) {
    const int column = i % kGridSide, row = i / kGridSide;
    const cv::Vec3d at = reference_from_frame * cv::Vec3d((column + 0.5) / kGridSide * size.width,
                                                          (row + 0.5) / kGridSide * size.height, 1.0);
    inside += at[0] >= 0.0 && at[1] >= 0.0 && at[0] < size.width && at[1] < size.height ? 1 : 0;
  }
  return static_cast<double>(inside) / (kGridSide * kGridSide);
}

}  // namespace

struct FrameMotion::State {
  cv::Mat before;
  Motion reference_from_now = Motion::eye(), reference_from_marked = Motion::eye();
};

FrameMotion::FrameMotion() : state_(std::make_unique<State>()) {}
FrameMotion::~FrameMotion() = default;

std::optional<double> FrameMotion::OverlapWithReference(const GrayFrame& frame) {
  const cv::Mat now = AsMat(frame).clone();
  if (state_->before.size() != now.size()) {
    state_->before = now;
    return std::nullopt;
  }
  const std::optional<Motion> motion = MotionBetween(state_->before, now);
  state_->before = now;
  if (!motion) return std::nullopt;
  state_->reference_from_now = state_->reference_from_now * *motion;
  return Overlap(state_->reference_from_now, now.size());
}

void FrameMotion::MakeReference() { state_->reference_from_now = Motion::eye(); }
void FrameMotion::Mark() { state_->reference_from_marked = state_->reference_from_now; }
void FrameMotion::MakeMarkedReference() {
  state_->reference_from_now = state_->reference_from_marked.inv() * state_->reference_from_now;
}

double Sharpness(const GrayFrame& frame) {
  cv::Mat laplacian;
  cv::Laplacian(AsMat(frame), laplacian, CV_16S);
  cv::Scalar mean, deviation;
  cv::meanStdDev(laplacian, mean, deviation);
  return deviation[0] * deviation[0];
}

}  // namespace skyquilt::video
