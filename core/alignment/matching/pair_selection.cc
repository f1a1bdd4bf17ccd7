#include "core/alignment/matching/pair_selection.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/alignment/matching/best_partners.h"

namespace skyquilt::alignment {
namespace {

constexpr double kMinPairOverlap = 0.12;
constexpr int kSamplesAcross = 7;
// Of how wide the ground is that a photo shows. Photos from far above see all of each one far below: were
// these their best partners, those of their own height would not be compared. (Two cameras side by side show
// the same ground in unlike pixels, and are compared as any.)
constexpr double kUnlikeScale = 2.0;
// Beyond this the one shows nothing of what the other's features are made of; what matches, does by chance.
constexpr double kMaxScaleRatio = 6.0;

// Ground points spread over a photo's picture.
std::vector<Eigen::Vector3d> SampleGround(const View& view, const Relief& relief) {
  std::vector<Eigen::Vector3d> points;
  for (int y = 0; y < kSamplesAcross; ++y) {
    for (int x = 0; x < kSamplesAcross; ++x) {
      Eigen::Vector3d point;
      const Eigen::Vector2d pixel = view.intrinsics.MiddleOfCell(x, y, kSamplesAcross);
      if (MeetGround(view, relief, pixel, &point)) points.push_back(point);
    }
  }
  return points;
}

bool Sees(const View& view, const Eigen::Vector3d& point, double margin_px) {
  const Eigen::Vector3d in_cam = view.cam_from_enu * point;
  if (in_cam.z() <= 0.0) return false;
  const camera::Intrinsics& lens = view.intrinsics;  // bending left out: this is about shares, not pixels
  const double x = lens.focal_x_px * in_cam.x() / in_cam.z() + lens.center_x_px;
  const double y = lens.focal_y_px * in_cam.y() / in_cam.z() + lens.center_y_px;
  return x > -margin_px && y > -margin_px && x < lens.width_px + margin_px && y < lens.height_px + margin_px;
}

double ScaleRatio(const View& a, const View& b) {
  return std::max(a.WidthM(), b.WidthM()) / std::max(1e-9, std::min(a.WidthM(), b.WidthM()));
}

bool AreUnlike(const View& a, const View& b) { return ScaleRatio(a, b) > kUnlikeScale; }

// One of BestPartners::kDirections.
int DirectionOf(const Eigen::Vector2d& away) {
  const double turn = (std::atan2(away.y(), away.x()) + std::numbers::pi) / (2.0 * std::numbers::pi);
  return std::min(BestPartners::kDirections - 1, static_cast<int>(turn * BestPartners::kDirections));
}

}  // namespace

bool AreOfComparableScale(const View& a, const View& b) { return ScaleRatio(a, b) <= kMaxScaleRatio; }

std::vector<PhotoPair> SelectPairs(const std::vector<View>& views, const std::vector<double>& ground_sigma_m,
                                   const Relief& relief) {
  const int count = static_cast<int>(views.size());
  std::vector<std::vector<Eigen::Vector3d>> samples(count);
  std::vector<Eigen::Vector2d> middle(count, Eigen::Vector2d::Zero());
  std::vector<double> reach(count, 0.0);
  for (int i = 0; i < count; ++i) {
    samples[i] = SampleGround(views[i], relief);
    if (samples[i].empty()) continue;
    for (const Eigen::Vector3d& point : samples[i]) middle[i] += point.head<2>() / samples[i].size();
    for (const Eigen::Vector3d& point : samples[i]) {
      reach[i] = std::max(reach[i], (point.head<2>() - middle[i]).norm());
    }
  }
  std::vector<int> by_east(count);
  for (int i = 0; i < count; ++i) by_east[i] = i;
  std::sort(by_east.begin(), by_east.end(), [&](int a, int b) {
    return middle[a].x() != middle[b].x() ? middle[a].x() < middle[b].x() : a < b;
  });
  const double widest = count == 0 ? 0.0 : *std::max_element(reach.begin(), reach.end());
  std::vector<BestPartners> of_photo(count);
  for (int k = 0; k < count; ++k) {
    const int i = by_east[k];
    if (samples[i].empty()) continue;
    for (int m = k + 1; m < count; ++m) {
      const int j = by_east[m];
      if (middle[j].x() - middle[i].x() > reach[i] + widest) break;
      if (samples[j].empty() || (middle[i] - middle[j]).norm() > reach[i] + reach[j]) continue;
      if (!AreOfComparableScale(views[i], views[j])) continue;
      // Of two that are unlike the narrower one's picture: it sees little of the other in any case.
      const bool are_unlike = AreUnlike(views[i], views[j]);
      const bool is_swapped = are_unlike && views[i].WidthM() > views[j].WidthM();
      const int from = is_swapped ? j : i, to = is_swapped ? i : j;
      const double margin_m = 1.5 * std::hypot(ground_sigma_m[i], ground_sigma_m[j]);
      const double margin_px = std::min(0.15 * views[to].intrinsics.width_px, margin_m / views[to].GsdM());
      const double shrinks = are_unlike ? std::pow(ScaleRatio(views[i], views[j]), 2) : 1.0;
      const int towards_j = DirectionOf(middle[j] - middle[i]),
                towards_i = DirectionOf(middle[i] - middle[j]);
      const auto share_of = [](std::size_t points) {
        return static_cast<double>(points) / (kSamplesAcross * kSamplesAcross);
      };
      const auto is_wanted = [&](std::size_t points) {
        if (share_of(points) < kMinPairOverlap) return false;
        const double overlap = share_of(points) / shrinks;
        if (are_unlike)
          return of_photo[i].WantsUnlike({-overlap, j}) || of_photo[j].WantsUnlike({-overlap, i});
        return of_photo[i].Wants({-overlap, j}, towards_j) || of_photo[j].Wants({-overlap, i}, towards_i);
      };
      // Counted no further than somebody wants what is left: of photos that hover each overlaps all others.
      std::size_t seen = samples[from].size();
      bool goes_on = is_wanted(seen);
      for (auto point = samples[from].begin(); goes_on && point != samples[from].end(); ++point) {
        if (!Sees(views[to], *point, margin_px)) goes_on = is_wanted(--seen);
      }
      if (!goes_on) continue;
      const double overlap = share_of(seen) / shrinks;
      if (are_unlike) {
        of_photo[i].AddUnlike({-overlap, j});
        of_photo[j].AddUnlike({-overlap, i});
        continue;
      }
      of_photo[i].Add({-overlap, j}, towards_j);
      of_photo[j].Add({-overlap, i}, towards_i);
    }
  }
  std::map<std::pair<int, int>, double> chosen;  // overlap
  for (int i = 0; i < count; ++i) {
    for (const auto& [minus_overlap, other] : of_photo[i].Chosen())
      chosen.emplace(std::minmax(i, other), -minus_overlap);
  }
  std::vector<PhotoPair> pairs;
  for (const auto& [photos, overlap] : chosen)
    pairs.push_back({.first = photos.first, .second = photos.second, .overlap = overlap});
  return pairs;
}

}  // namespace skyquilt::alignment
