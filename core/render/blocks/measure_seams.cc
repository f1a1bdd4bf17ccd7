#include "core/render/blocks/measure_seams.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/camera/rolling_shutter.h"
#include "core/render/blocks/render_block.h"

namespace skyquilt::render {
namespace {

constexpr std::size_t kMaxPairs = 60;
constexpr int kPatch = 256;
constexpr int kNode = 16;       // exact every so many samples, bilinear between
constexpr int kSampleGsds = 2;  // pixels of the photo to a sample, at least
constexpr double kAcross[] = {-0.25,
                              0.25};  // patches of a pair, along its seam, in distances between the two
constexpr double kMinAlike = 0.4;     // correlation once the shift is undone
constexpr double kMaxShiftShare = 0.3;

struct Seam {
  std::size_t first = 0, second = 0;
  Eigen::Vector2d middle;
  Eigen::Vector2d along;  // the seam, as long as the photos are apart
};

double GsdM(const alignment::AlignedPhoto& photo) {
  return photo.height_above_ground_m / photo.intrinsics.MeanFocalPx();
}

// Pairs of which no third camera stands nearer to the place half-way. Photos that show nothing of the map (a
// look of 0) have no seams.
std::vector<Seam> FindSeams(const alignment::AlignedFlight& flight) {
  std::vector<std::size_t> shown;
  std::vector<Eigen::Vector2d> nadirs;
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    if (!(flight.photos[i].max_look_rad > 0.0)) continue;
    shown.push_back(i);
    nadirs.push_back(flight.photos[i].cam_from_enu.TargetOriginInSource().head<2>());
  }
  const std::size_t count = shown.size();
  std::vector<Seam> seams;
  for (std::size_t i = 0; i < count; ++i) {
    const alignment::AlignedPhoto& photo = flight.photos[shown[i]];
    const double reach_m = GsdM(photo) * photo.intrinsics.width_px;
    for (std::size_t j = i + 1; j < count; ++j) {
      const Eigen::Vector2d apart = nadirs[j] - nadirs[i];
      if (apart.norm() > reach_m || apart.norm() < 0.02 * reach_m) continue;
      const Eigen::Vector2d middle = 0.5 * (nadirs[i] + nadirs[j]);
      const double near_m = 0.5 * apart.norm();
      const bool is_ours = std::none_of(nadirs.begin(), nadirs.end(), [&](const Eigen::Vector2d& other) {
        return (other - middle).norm() < 0.99 * near_m;
      });
      if (is_ours) seams.push_back({shown[i], shown[j], middle, {-apart.y(), apart.x()}});
    }
  }
  return seams;
}

// Where a photo sees a patch.
struct PatchInPhoto {
  cv::Mat nodes_x, nodes_y;  // of the shrunk part's pixels
  cv::Rect part;             // needed of the shrunk photo, with a pixel around
  int shrink = 1;     // pixels of the decoded photo to one: finer ones are averaged, or they would alias
  cv::Mat projected;  // once the photo was decoded: seen straight from above, grey

  // Of the full-size photo.
  image::PixelBox Box(int denominator) const {
    const int d = denominator * shrink;
    return {part.x * d, part.y * d, (part.x + part.width) * d, (part.y + part.height) * d};
  }
};

struct Patch {
  Eigen::Vector2d middle;
  double sample_m = 0.0;
};

// Nothing when the photo does not show all of it.
std::optional<PatchInPhoto> FindPatch(const alignment::AlignedPhoto& photo, int denominator,
                                      const ground::GroundSurface& ground, const Patch& patch) {
  PatchInPhoto found;
  found.shrink = denominator < kSampleGsds ? kSampleGsds / denominator : 1;
  const double scale = 1.0 / (denominator * found.shrink);
  constexpr int kNodes = kPatch / kNode + 1;
  found.nodes_x.create(kNodes, kNodes, CV_32F);
  found.nodes_y.create(kNodes, kNodes, CV_32F);
  for (int row = 0; row < kNodes; ++row) {
    for (int column = 0; column < kNodes; ++column) {
      const Eigen::Vector2d at = patch.middle + patch.sample_m * Eigen::Vector2d(column * kNode - kPatch / 2,
                                                                                 kPatch / 2 - row * kNode);
      const auto pixel = camera::ProjectRolling(photo.intrinsics, photo.cam_from_enu, photo.readout_motion,
                                                {at.x(), at.y(), ground.HeightAt(at)});
      if (!pixel || !photo.intrinsics.IsInImage(*pixel)) return std::nullopt;
      found.nodes_x.at<float>(row, column) = static_cast<float>((pixel->x() + 0.5) * scale - 0.5);
      found.nodes_y.at<float>(row, column) = static_cast<float>((pixel->y() + 0.5) * scale - 0.5);
    }
  }
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;
  cv::minMaxLoc(found.nodes_x, &left, &right);
  cv::minMaxLoc(found.nodes_y, &top, &bottom);
  const auto shrunk = [&](int side_px) { return (side_px + denominator - 1) / denominator / found.shrink; };
  const cv::Rect whole(0, 0, shrunk(photo.intrinsics.width_px), shrunk(photo.intrinsics.height_px));
  found.part = cv::Rect(cv::Point(static_cast<int>(left) - 1, static_cast<int>(top) - 1),
                        cv::Point(static_cast<int>(right) + 3, static_cast<int>(bottom) + 3)) &
               whole;
  if (found.part.empty()) return std::nullopt;
  found.nodes_x -= found.part.x;
  found.nodes_y -= found.part.y;
  return found;
}

cv::Mat ProjectPatch(const PatchInPhoto& where, const image::DecodedPart& photo) {
  const image::DecodedImage& image = photo.image;
  const cv::Rect& part = where.part;
  const int shrink = where.shrink;
  const cv::Rect needed(part.x * shrink - photo.left_px, part.y * shrink - photo.top_px, part.width * shrink,
                        part.height * shrink);
  if ((needed & cv::Rect(0, 0, image.width_px, image.height_px)) != needed) return {};
  const cv::Mat &nodes_x = where.nodes_x, &nodes_y = where.nodes_y;
  const cv::Mat rgb(image.height_px, image.width_px, CV_8UC3, const_cast<std::uint8_t*>(image.rgb.data()));
  cv::Mat grey;
  cv::cvtColor(rgb(needed), grey, cv::COLOR_RGB2GRAY);
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
  cv::Mat projected;
  cv::remap(grey, projected, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return projected;
}

// Freed of slow changes of brightness.
cv::Mat Sharp(const cv::Mat& projected) {
  cv::Mat patch, coarse, slow;
  projected.convertTo(patch, CV_32F);
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
  if (std::hypot(shift.x, shift.y) > kMaxShiftShare * kPatch) return std::nullopt;
  const cv::Mat move = (cv::Mat_<double>(2, 3) << 1.0, 0.0, shift.x, 0.0, 1.0, shift.y);
  cv::Mat back;
  cv::warpAffine(second, back, move, second.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REFLECT);
  if (Alike(first.mul(window), back.mul(window)) < kMinAlike) return std::nullopt;
  return std::hypot(shift.x, shift.y);
}

}  // namespace

// What of a seam both photos show, in both.
struct SeamPatches::InBoth {
  std::size_t first = 0, second = 0;  // photos
  PatchInPhoto in_first, in_second;
  double sample_m = 0.0;
};

SeamPatches::SeamPatches(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                         const MeasureSeamsOptions& options)
    : flight_(flight), options_(options), patches_of_(flight.photos.size()) {
  for (const alignment::AlignedPhoto& photo : flight.photos)
    denominators_.push_back(DenominatorFor(photo, options.output_pixel_m));
  const std::vector<Seam> all = FindSeams(flight);
  for (std::size_t k = 0; k < std::min(kMaxPairs, all.size()); ++k) {
    const Seam& seam = all[all.size() <= kMaxPairs ? k : k * all.size() / kMaxPairs];
    const alignment::AlignedPhoto& a = flight.photos[seam.first];
    const alignment::AlignedPhoto& b = flight.photos[seam.second];
    const int scale_a = denominators_[seam.first], scale_b = denominators_[seam.second];
    const double sample_m = std::max({kSampleGsds, scale_a, scale_b}) * std::max(GsdM(a), GsdM(b));
    for (const double across : kAcross) {
      const Patch patch{seam.middle + across * seam.along, sample_m};
      auto in_first = FindPatch(a, scale_a, ground, patch);
      auto in_second = in_first ? FindPatch(b, scale_b, ground, patch) : std::nullopt;
      if (!in_second) continue;
      patches_of_[seam.first].push_back(patches_.size());
      patches_of_[seam.second].push_back(patches_.size());
      patches_.push_back({seam.first, seam.second, *std::move(in_first), *std::move(in_second), sample_m});
    }
  }
}

SeamPatches::~SeamPatches() = default;

void SeamPatches::WatchFor(PhotoCache& cache) {
  for (const InBoth& patch : patches_) {
    cache.Expect(patch.first, patch.in_first.Box(denominators_[patch.first]));
    cache.Expect(patch.second, patch.in_second.Box(denominators_[patch.second]));
  }
  cache.OnDecoded([this](std::size_t photo, int denominator, const image::DecodedPart& decoded) {
    Project(photo, denominator, decoded);
  });
}

void SeamPatches::Project(std::size_t photo, int denominator, const image::DecodedPart& decoded) {
  if (denominator != denominators_[photo]) return;
  for (const std::size_t k : patches_of_[photo]) {
    PatchInPhoto& here = patches_[k].first == photo ? patches_[k].in_first : patches_[k].in_second;
    if (here.projected.empty()) here.projected = ProjectPatch(here, decoded);
  }
}

SeamShift SeamPatches::Measure(PhotoCache& cache, Progress& progress) {
  SeamShift result;
  std::vector<char> is_looked_at(patches_.size(), 0);
  std::vector<std::optional<double>> found_m(patches_.size());
  ParallelFor(patches_.size(), options_.threads, [&](std::size_t k) {
    if (progress.IsCancelled()) return;
    const InBoth& patch = patches_[k];
    const auto seen = [&](std::size_t photo, const PatchInPhoto& where) -> cv::Mat {
      if (!where.projected.empty()) return Sharp(where.projected);
      const int denominator = denominators_[photo];
      const auto decoded = cache.Get(photo, flight_.photos[photo].photo, denominator, where.Box(denominator));
      return decoded ? Sharp(ProjectPatch(where, **decoded)) : cv::Mat();
    };
    const cv::Mat fixed = seen(patch.first, patch.in_first), moving = seen(patch.second, patch.in_second);
    if (fixed.empty() || moving.empty()) return;
    is_looked_at[k] = 1;
    if (const auto shift = ShiftBetween(fixed, moving)) found_m[k] = *shift * patch.sample_m;
  });
  std::vector<double> shifts_m, gsds_m;
  for (std::size_t k = 0; k < patches_.size(); ++k) {
    result.patches += is_looked_at[k];
    if (found_m[k]) shifts_m.push_back(*found_m[k]);
  }
  for (const alignment::AlignedPhoto& photo : flight_.photos) gsds_m.push_back(GsdM(photo));
  result.reliable = static_cast<int>(shifts_m.size());
  if (!gsds_m.empty()) result.gsd_m = Percentile(gsds_m, 0.5);
  if (!shifts_m.empty()) {
    result.median_m = Percentile(shifts_m, 0.5);
    result.p90_m = Percentile(shifts_m, 0.9);
  }
  return result;
}

}  // namespace skyquilt::render
