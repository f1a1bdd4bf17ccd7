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
#include "core/render/render_block.h"

namespace skyquilt::render {
namespace {

constexpr int kPatch = 256;
constexpr int kNode = 16;       // exact every so many samples, bilinear between
constexpr int kSampleGsds = 2;  // pixels of the photo to a sample, at least
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
cv::Mat LayPatch(const alignment::AlignedPhoto& photo, const pipeline::DecodedImage& image, int denominator,
                 const ground::GroundSurface& ground, const Eigen::Vector2d& middle, double sample_m) {
  // Finer pixels than the samples are averaged, or they would alias.
  const int shrink = denominator < kSampleGsds ? kSampleGsds / denominator : 1;
  const double scale = 1.0 / (denominator * shrink);
  constexpr int kNodes = kPatch / kNode + 1;
  cv::Mat nodes_x(kNodes, kNodes, CV_32F), nodes_y(kNodes, kNodes, CV_32F);
  for (int row = 0; row < kNodes; ++row) {
    for (int column = 0; column < kNodes; ++column) {
      const Eigen::Vector2d at =
          middle + sample_m * Eigen::Vector2d(column * kNode - kPatch / 2, kPatch / 2 - row * kNode);
      const auto pixel =
          photo.intrinsics.Project(photo.cam_from_enu * Eigen::Vector3d(at.x(), at.y(), ground.HeightAt(at)));
      if (!pixel || !photo.intrinsics.IsInImage(*pixel)) return {};
      nodes_x.at<float>(row, column) = static_cast<float>((pixel->x() + 0.5) * scale - 0.5);
      nodes_y.at<float>(row, column) = static_cast<float>((pixel->y() + 0.5) * scale - 0.5);
    }
  }
  // The part of the photo that is needed, with a pixel around.
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;
  cv::minMaxLoc(nodes_x, &left, &right);
  cv::minMaxLoc(nodes_y, &top, &bottom);
  const cv::Rect whole(0, 0, image.width_px / shrink, image.height_px / shrink);
  const cv::Rect part = cv::Rect(cv::Point(static_cast<int>(left) - 1, static_cast<int>(top) - 1),
                                 cv::Point(static_cast<int>(right) + 3, static_cast<int>(bottom) + 3)) &
                        whole;
  if (part.empty()) return {};
  nodes_x -= part.x;
  nodes_y -= part.y;
  const cv::Mat rgb(image.height_px, image.width_px, CV_8UC3, const_cast<std::uint8_t*>(image.rgb.data()));
  cv::Mat grey;
  cv::cvtColor(rgb(cv::Rect(part.x * shrink, part.y * shrink, part.width * shrink, part.height * shrink)),
               grey, cv::COLOR_RGB2GRAY);
  if (shrink > 1) cv::resize(grey, grey, part.size(), 0, 0, cv::INTER_AREA);
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
  cv::Mat sampled, patch, coarse, slow;
  cv::remap(grey, sampled, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  sampled.convertTo(patch, CV_32F);
  // What is this slow needs no fine pixels.
  constexpr int kCoarser = 4;
  cv::resize(patch, coarse, {kPatch / kCoarser, kPatch / kCoarser}, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(coarse, coarse, {}, kPatch / 16.0 / kCoarser);
  cv::resize(coarse, slow, patch.size(), 0, 0, cv::INTER_LINEAR);
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
                       PhotoCache& cache, const MeasureSeamsOptions& options, Progress& progress) {
  const std::vector<Seam> all = FindSeams(flight);
  std::vector<Seam> seams;
  const std::size_t most = static_cast<std::size_t>(options.most_pairs);
  for (std::size_t k = 0; k < std::min(most, all.size()); ++k) {
    seams.push_back(all[all.size() <= most ? k : k * all.size() / most]);
  }
  SeamShift result;
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
    const int scale_a = DenominatorFor(a, options.output_pixel_m);
    const int scale_b = DenominatorFor(b, options.output_pixel_m);
    const auto first = cache.Get(seam.first, a.photo, scale_a);
    const auto second = cache.Get(seam.second, b.photo, scale_b);
    if (!first || !second) return;
    const double sample_m = std::max({kSampleGsds, scale_a, scale_b}) * std::max(GsdM(a), GsdM(b));
    for (const double across : kAcross) {
      const Eigen::Vector2d middle = seam.middle + across * seam.along;
      const cv::Mat fixed = LayPatch(a, **first, scale_a, ground, middle, sample_m);
      const cv::Mat moving = LayPatch(b, **second, scale_b, ground, middle, sample_m);
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
