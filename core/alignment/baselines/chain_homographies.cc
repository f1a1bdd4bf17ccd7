#include "core/alignment/baselines/chain_homographies.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/alignment/estimators/plane_homography.h"
#include "core/alignment/matching/guided_matching.h"
#include "core/alignment/scene/matches.h"
#include "core/base/median.h"
#include "core/base/parallel_for.h"

namespace skyquilt::alignment {
namespace {

constexpr int kMaxStepsBack = 3;
constexpr std::size_t kMaxNeighbours = 4;
constexpr double kNeighbourShare = 0.75;   // of a photo's diagonal between middles: farther hardly overlaps
constexpr double kToleranceShare = 0.004;  // of the photo's width
constexpr double kMaxGrowth = 6.0;         // of a photo's area in the mosaic: more is a broken chain

// Keypoints in the plane of the picture itself, so that matching uses appearance alone.
std::vector<GroundKeypoint> PictureAsGround(const PhotoFeatures& features) {
  std::vector<GroundKeypoint> projected;
  projected.reserve(features.keypoints.size());
  for (const Keypoint& keypoint : features.keypoints) {
    projected.push_back({{keypoint.x_px, keypoint.y_px},
                         keypoint.angle_rad,
                         std::log2(std::max(1e-3F, keypoint.scale_px)),
                         true});
  }
  return projected;
}

class Chain {
 public:
  Chain(const std::vector<const PhotoFeatures*>& features, const std::vector<camera::Intrinsics>& lenses,
        int threads)
      : lenses_(lenses), threads_(threads), views_(features.size()), places_(features.size()) {
    mosaic_.photos.resize(features.size());
    ParallelFor(features.size(), threads, [&](std::size_t i) {
      if (features[i] == nullptr) return;
      views_[i] = {features[i], PictureAsGround(*features[i])};
      for (const Keypoint& keypoint : features[i]->keypoints) {
        places_[i].push_back(PlaceInPhoto(lenses[i], {keypoint.x_px, keypoint.y_px}));
      }
    });
  }

  void Add(int photo) {
    ChainedPhoto& added = mosaic_.photos[photo];
    if (views_[photo].features == nullptr) return;
    std::optional<Eigen::Matrix3d> chained;
    std::vector<int> others;
    for (int back = 1; back <= kMaxStepsBack && photo - back >= 0 && !chained; ++back) {
      const int other = photo - back;
      if (mosaic_.photos[other].component < 0) continue;
      others = {other};
      const std::vector<Matched> matched = MatchAll(photo, others);
      if (matched.empty()) continue;
      chained = mosaic_.photos[other].mosaic_from_photo * matched.front().fit.to_from;
      if (!IsSound(photo, *chained)) chained.reset();
    }
    if (!chained) {
      added.component = mosaic_.components++;
      return;
    }
    added.component = mosaic_.photos[others.front()].component;
    added.mosaic_from_photo = *chained;
    for (const int other : Neighbours(photo)) {
      if (other != others.front()) others.push_back(other);
    }
    RegisterToMosaic(photo, MatchAll(photo, others));
  }

  ChainedMosaic Take() { return std::move(mosaic_); }

 private:
  struct Matched {
    int other = 0;
    std::vector<PlanePair> pairs;  // that agree: from this photo to the other
    RobustFit fit;
  };

  double TolerancePx(int photo) const { return kToleranceShare * lenses_[photo].width_px; }

  std::vector<Matched> MatchAll(int photo, const std::vector<int>& others) {
    std::vector<Matched> matched =
        ParallelCollect(others.size(), threads_, [&](std::size_t k) { return Match(photo, others[k]); });
    mosaic_.pairs_tried += static_cast<int>(others.size());
    mosaic_.pairs_linked += static_cast<int>(matched.size());
    return matched;
  }

  std::optional<Matched> Match(int photo, int other) const {
    MatchWindow everywhere;
    everywhere.max_log2_scale = std::numeric_limits<double>::infinity();
    everywhere.max_distance_ratio = 0.8;
    std::vector<PlanePair> pairs;
    for (const KeypointMatch& match : MatchOnGround(views_[photo], views_[other], everywhere)) {
      pairs.push_back({places_[photo][match.first], places_[other][match.second]});
    }
    std::optional<RobustFit> fit = RobustHomography(pairs, TolerancePx(other));
    if (!fit) return std::nullopt;
    Matched matched{other, {}, *std::move(fit)};
    for (const int k : matched.fit.inliers) matched.pairs.push_back(pairs[k]);
    return matched;
  }

  std::array<Eigen::Vector2d, 4> Corners(int photo) const {
    const camera::Intrinsics& lens = lenses_[photo];
    const double x = lens.width_px - 1, y = lens.height_px - 1;
    return {PlaceInPhoto(lens, {0.0, 0.0}), PlaceInPhoto(lens, {x, 0.0}), PlaceInPhoto(lens, {x, y}),
            PlaceInPhoto(lens, {0.0, y})};
  }

  // A photo of the ground from above stays a convex quadrangle of about its size, not mirrored.
  bool IsSound(int photo, const Eigen::Matrix3d& mosaic_from_photo) const {
    std::array<Eigen::Vector2d, 4> mapped;
    const std::array<Eigen::Vector2d, 4> corners = Corners(photo);
    double area = 0.0, own_area = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto place = MapPlace(mosaic_from_photo, corners[k]);
      if (!place) return false;
      mapped[k] = *place;
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d side = mapped[(k + 1) % 4] - mapped[k];
      const Eigen::Vector2d next = mapped[(k + 2) % 4] - mapped[(k + 1) % 4];
      if (side.x() * next.y() - side.y() * next.x() <= 0.0) return false;
      area += 0.5 * (mapped[k].x() * mapped[(k + 1) % 4].y() - mapped[k].y() * mapped[(k + 1) % 4].x());
      own_area +=
          0.5 * (corners[k].x() * corners[(k + 1) % 4].y() - corners[k].y() * corners[(k + 1) % 4].x());
    }
    return area < kMaxGrowth * own_area && own_area < kMaxGrowth * area;
  }

  // Photos of the component that lie around this one, the nearest first.
  std::vector<int> Neighbours(int photo) const {
    const ChainedPhoto& added = mosaic_.photos[photo];
    const Eigen::Vector2d middle = added.mosaic_from_photo.col(2).hnormalized();
    const std::array<Eigen::Vector2d, 4> corners = Corners(photo);
    const auto first = MapPlace(added.mosaic_from_photo, corners[0]);
    const auto last = MapPlace(added.mosaic_from_photo, corners[2]);
    if (!first || !last) return {};
    const double reach = kNeighbourShare * (*last - *first).norm();
    std::vector<std::pair<double, int>> near;
    for (int other = 0; other < photo; ++other) {
      const ChainedPhoto& placed = mosaic_.photos[other];
      if (placed.component != added.component) continue;
      const double apart = (placed.mosaic_from_photo.col(2).hnormalized() - middle).norm();
      if (apart < reach) near.emplace_back(apart, other);
    }
    return LeastFew(std::move(near), kMaxNeighbours);
  }

  // Eq. 3: one homography for all that the mosaic already shows of this photo.
  void RegisterToMosaic(int photo, const std::vector<Matched>& matched) {
    ChainedPhoto& added = mosaic_.photos[photo];
    std::vector<PlanePair> pairs;
    double scale = 0.0;
    for (const Matched& one : matched) {
      const Eigen::Matrix3d& mosaic_from_other = mosaic_.photos[one.other].mosaic_from_photo;
      for (const PlanePair& pair : one.pairs) {
        if (const auto place = MapPlace(mosaic_from_other, pair.to)) pairs.push_back({pair.from, *place});
      }
      scale = std::max(scale, std::sqrt(std::abs(mosaic_from_other.topLeftCorner<2, 2>().determinant())));
    }
    added.links = static_cast<int>(matched.size());
    const double tolerance = 2.0 * TolerancePx(photo) * std::max(scale, 1e-3);
    const auto fit = RobustHomography(pairs, tolerance);
    if (fit && IsSound(photo, fit->to_from)) added.mosaic_from_photo = fit->to_from;
    for (const PlanePair& pair : pairs) {
      const auto place = MapPlace(added.mosaic_from_photo, pair.from);
      if (!place || (*place - pair.to).norm() > tolerance) continue;
      ++added.inliers;
      added.square_px += (*place - pair.to).squaredNorm() / (scale * scale);
    }
  }

  const std::vector<camera::Intrinsics>& lenses_;
  const int threads_;
  std::vector<GroundView> views_;
  std::vector<std::vector<Eigen::Vector2d>> places_;
  ChainedMosaic mosaic_;
};

}  // namespace

Eigen::Vector2d PlaceInPhoto(const camera::Intrinsics& lens, const Eigen::Vector2d& pixel_in_image) {
  return lens.MeanFocalPx() * lens.Unproject(pixel_in_image).head<2>();
}

ChainedMosaic ChainHomographies(const std::vector<const PhotoFeatures*>& features,
                                const std::vector<camera::Intrinsics>& lenses, int threads,
                                Progress& progress) {
  Chain chain(features, lenses, threads);
  const auto count = static_cast<int>(features.size());
  for (int photo = 0; photo < count && !progress.IsCancelled(); ++photo) {
    chain.Add(photo);
    progress.Report(0.7 + 0.3 * (photo + 1) / count, "chaining photos");
  }
  return chain.Take();
}

}  // namespace skyquilt::alignment
