#include "core/render/measure_seams.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "core/base/parallel_for.h"
#include "core/base/percentile.h"
#include "core/render/photo_cache.h"

namespace skyquilt::render {
namespace {

constexpr int kPatch = 256;
constexpr int kNode = 16;            // exact every so many samples, bilinear between
constexpr double kSampleGsds = 2.0;  // photos are decoded at half size
constexpr double kAcross[] = {-0.25,
                              0.25};  // patches of a pair, along its seam, in distances between the two
constexpr double kMinAlike = 0.4;     // correlation once the shift is undone
constexpr double kMostShiftShare = 0.3;

struct Seam {
  std::size_t first = 0, second = 0;
  Eigen::Vector2d middle;
  Eigen::Vector2d along;  // the seam, as long as the photos are apart
};

double GsdM(const alignment::AlignedPhoto& photo) {
  return photo.height_above_ground_m / photo.intrinsics.MeanFocalPx();
}

// Pairs of which no third camera stands nearer to the place half-way.
std::vector<Seam> FindSeams(const alignment::AlignedFlight& flight) {
  const std::size_t count = flight.photos.size();
  std::vector<Eigen::Vector2d> nadirs;
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    nadirs.push_back(photo.cam_from_enu.TargetOriginInSource().head<2>());
  }
  std::vector<Seam> seams;
  for (std::size_t i = 0; i < count; ++i) {
    const double reach_m = GsdM(flight.photos[i]) * flight.photos[i].intrinsics.width_px;
    for (std::size_t j = i + 1; j < count; ++j) {
      const Eigen::Vector2d apart = nadirs[j] - nadirs[i];
      if (apart.norm() > reach_m || apart.norm() < 0.02 * reach_m) continue;
      const Eigen::Vector2d middle = 0.5 * (nadirs[i] + nadirs[j]);
      const double near_m = 0.5 * apart.norm();
      const bool is_ours = std::none_of(nadirs.begin(), nadirs.end(), [&](const Eigen::Vector2d& other) {
        return (other - middle).norm() < 0.99 * near_m;
      });
      if (is_ours) seams.push_back({i, j, middle, {-apart.y(), apart.x()}});
    }
  }
  return seams;
}

// The photo seen straight from above around a place, grey, freed of slow brightness changes; empty when it
// does not show all of it.
cv::Mat LayPatch(const alignment::AlignedPhoto& photo, const pipeline::DecodedImage& image,
                 const ground::GroundSurface& ground, const Eigen::Vector2d& middle, double sample_m) {
  const double scale_x = static_cast<double>(image.width_px) / photo.intrinsics.width_px;
  const double scale_y = static_cast<double>(image.height_px) / photo.intrinsics.height_px;
  constexpr int kNodes = kPatch / kNode + 1;
  cv::Mat nodes_x(kNodes, kNodes, CV_32F), nodes_y(kNodes, kNodes, CV_32F);
  for (int row = 0; row < kNodes; ++row) {
    for (int column = 0; column < kNodes; ++column) {
      const Eigen::Vector2d at =
          middle + sample_m * Eigen::Vector2d(column * kNode - kPatch / 2, kPatch / 2 - row * kNode);
      const auto pixel =
          photo.intrinsics.Project(photo.cam_from_enu * Eigen::Vector3d(at.x(), at.y(), ground.HeightAt(at)));
      if (!pixel || !photo.intrinsics.IsInImage(*pixel)) return {};
      nodes_x.at<float>(row, column) = static_cast<float>((pixel->x() + 0.5) * scale_x - 0.5);
      nodes_y.at<float>(row, column) = static_cast<float>((pixel->y() + 0.5) * scale_y - 0.5);
    }
  }
  cv::Mat map_x(kPatch, kPatch, CV_32F), map_y(kPatch, kPatch, CV_32F);
  for (int row = 0; row < kPatch; ++row) {
    for (int column = 0; column < kPatch; ++column) {
      const int r = row / kNode, c = column / kNode;
      const float u = static_cast<float>(column % kNode) / kNode, v = static_cast<float>(row % kNode) / kNode;
      const auto between = [&](const cv::Mat& nodes) {
        return (1 - v) * ((1 - u) * nodes.at<float>(r, c) + u * nodes.at<float>(r, c + 1)) +
               v * ((1 - u) * nodes.at<float>(r + 1, c) + u * nodes.at<float>(r + 1, c + 1));
      };
      map_x.at<float>(row, column) = between(nodes_x);
      map_y.at<float>(row, column) = between(nodes_y);
    }
  }
  const cv::Mat rgb(image.height_px, image.width_px, CV_8UC3, const_cast<std::uint8_t*>(image.rgb.data()));
  cv::Mat sampled, grey, patch, slow;
  cv::remap(rgb, sampled, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::cvtColor(sampled, grey, cv::COLOR_RGB2GRAY);
  grey.convertTo(patch, CV_32F);
  cv::GaussianBlur(patch, slow, {}, kPatch / 16.0);
  return patch - slow;
}

double Alike(const cv::Mat& a, const cv::Mat& b) {
  const double ab = a.dot(b), aa = a.dot(a), bb = b.dot(b);
  return aa > 1e-6 && bb > 1e-6 ? ab / std::sqrt(aa * bb) : 0.0;
}

// How far the second shows things from where the first does, in samples; nothing where they do not look
// alike.
std::optional<double> ShiftBetween(const cv::Mat& first, const cv::Mat& second) {
  cv::Mat window;
  cv::createHanningWindow(window, first.size(), CV_32F);
  const cv::Point2d shift = cv::phaseCorrelate(first, second, window);
  if (std::hypot(shift.x, shift.y) > kMostShiftShare * kPatch) return std::nullopt;
  const cv::Mat move = (cv::Mat_<double>(2, 3) << 1.0, 0.0, shift.x, 0.0, 1.0, shift.y);
  cv::Mat back;
  cv::warpAffine(second, back, move, second.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REFLECT);
  if (Alike(first.mul(window), back.mul(window)) < kMinAlike) return std::nullopt;
  return std::hypot(shift.x, shift.y);
}

}  // namespace

SeamShift MeasureSeams(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                       const pipeline::PhotoSource& source, const MeasureSeamsOptions& options,
                       Progress& progress) {
  const std::vector<Seam> all = FindSeams(flight);
  std::vector<Seam> seams;
  const std::size_t most = static_cast<std::size_t>(options.most_pairs);
  for (std::size_t k = 0; k < std::min(most, all.size()); ++k) {
    seams.push_back(all[all.size() <= most ? k : k * all.size() / most]);
  }
  SeamShift result;
  PhotoCache cache(source, options.budget_bytes);
  struct Looked {
    int patches = 0;
    std::vector<double> shifts_m;
  };
  std::vector<Looked> looked(seams.size());
  ParallelFor(seams.size(), options.threads, [&](std::size_t s) {
    if (progress.IsCancelled()) return;
    const Seam& seam = seams[s];
    const alignment::AlignedPhoto& a = flight.photos[seam.first];
    const alignment::AlignedPhoto& b = flight.photos[seam.second];
    const auto first = cache.Get(seam.first, a.photo, 2);
    const auto second = cache.Get(seam.second, b.photo, 2);
    if (!first || !second) return;
    const double sample_m = kSampleGsds * std::max(GsdM(a), GsdM(b));
    for (const double across : kAcross) {
      const Eigen::Vector2d middle = seam.middle + across * seam.along;
      const cv::Mat fixed = LayPatch(a, **first, ground, middle, sample_m);
      const cv::Mat moving = LayPatch(b, **second, ground, middle, sample_m);
      if (fixed.empty() || moving.empty()) continue;
      ++looked[s].patches;
      if (const auto shift = ShiftBetween(fixed, moving)) looked[s].shifts_m.push_back(*shift * sample_m);
    }
  });
  std::vector<double> shifts_m, gsds_m;
  for (const Looked& one : looked) {
    result.patches += one.patches;
    shifts_m.insert(shifts_m.end(), one.shifts_m.begin(), one.shifts_m.end());
  }
  for (const alignment::AlignedPhoto& photo : flight.photos) gsds_m.push_back(GsdM(photo));
  result.reliable = static_cast<int>(shifts_m.size());
  if (!gsds_m.empty()) result.gsd_m = Percentile(gsds_m, 0.5);
  if (!shifts_m.empty()) {
    result.median_m = Percentile(shifts_m, 0.5);
    result.p90_m = Percentile(shifts_m, 0.9);
  }
  return result;
}

std::string SeamShiftJson(const SeamShift& shift) {
  const double gsd_m = shift.gsd_m > 0.0 ? shift.gsd_m : 1.0;
  const nlohmann::ordered_json json = {
      {"patches", shift.patches}, {"reliable", shift.reliable},           {"median_m", shift.median_m},
      {"p90_m", shift.p90_m},     {"median_gsd", shift.median_m / gsd_m}, {"p90_gsd", shift.p90_m / gsd_m}};
  return json.dump(2);
}

}  // namespace skyquilt::render
