#include "core/alignment/from_records/direct_registration.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/parallel_for.h"

namespace skyquilt::alignment {
namespace {

constexpr int kPatch = 128;           // samples a side
constexpr double kPatchShare = 0.55;  // of the photo's shorter side on the ground
constexpr double kMinOverlap = 0.35;
constexpr double kMinDistinctness = 1.8;
constexpr double kMinInside = 0.85;  // of the patch, in both photos
constexpr int kPeakRadius = 6;
constexpr double kLeftOverPx = 0.75;
constexpr double kMinContrast = 1.0;  // grey levels: less is noise
constexpr double kSigmas = 3.5;
constexpr int kEnoughPairs = 2;

struct Patch {
  cv::Mat grey;  // CV_32F
  double inside = 0.0;
};

// The thumbnail seen straight from above: north is up, `cell_m` a sample, around a place.
Patch ProjectThumbnail(const MatchedFlight& input, int photo, const Eigen::Vector3d& place, double cell_m) {
  const View& view = input.views[photo];
  const Thumbnail& thumbnail = input.features[photo]->thumbnail;
  const cv::Mat source(thumbnail.height_px, thumbnail.width_px, CV_8U,
                       const_cast<std::uint8_t*>(thumbnail.grey.data()));
  const double scale_x = static_cast<double>(thumbnail.width_px) / view.intrinsics.width_px;
  const double scale_y = static_cast<double>(thumbnail.height_px) / view.intrinsics.height_px;
  cv::Mat map_x(kPatch, kPatch, CV_32F), map_y(kPatch, kPatch, CV_32F);
  int inside = 0;
  for (int row = 0; row < kPatch; ++row) {
    for (int column = 0; column < kPatch; ++column) {
      const int cells_east = column - kPatch / 2, cells_north = kPatch / 2 - row;
      const Eigen::Vector3d point = place + Eigen::Vector3d(cells_east * cell_m, cells_north * cell_m, 0.0);
      const Eigen::Vector3d in_cam = view.cam_from_enu * point;
      float x = -10.0F, y = -10.0F;
      if (in_cam.z() > 1e-3) {
        const Eigen::Vector2d full = view.intrinsics.ProjectBeyondFold(in_cam);
        x = static_cast<float>((full.x() + 0.5) * scale_x - 0.5);
        y = static_cast<float>((full.y() + 0.5) * scale_y - 0.5);
      }
      if (x >= 0.0F && y >= 0.0F && x <= thumbnail.width_px - 1.0F && y <= thumbnail.height_px - 1.0F)
        ++inside;
      map_x.at<float>(row, column) = x;
      map_y.at<float>(row, column) = y;
    }
  }
  Patch patch;
  patch.inside = static_cast<double>(inside) / (kPatch * kPatch);
  cv::Mat sampled;
  cv::remap(source, sampled, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::Mat smooth;
  sampled.convertTo(patch.grey, CV_32F);
  cv::GaussianBlur(patch.grey, smooth, {}, kPatch / 16.0);
  patch.grey -= smooth;
  return patch;
}

struct Peak {
  cv::Point2d shift_px;
  double distinctness = 0.0;
};

// How the second patch must be shifted against the first; the best peak against the best away from it.
Peak CorrelatePhase(const cv::Mat& first, const cv::Mat& second, double reach_px) {
  cv::Mat window;
  cv::createHanningWindow(window, first.size(), CV_32F);
  cv::Mat a, b, cross, surface;
  cv::dft(first.mul(window), a, cv::DFT_COMPLEX_OUTPUT);
  cv::dft(second.mul(window), b, cv::DFT_COMPLEX_OUTPUT);
  cv::mulSpectrums(b, a, cross, 0, true);
  for (int row = 0; row < cross.rows; ++row) {
    for (int column = 0; column < cross.cols; ++column) {
      cv::Vec2f& value = cross.at<cv::Vec2f>(row, column);
      const int fy = std::min(row, cross.rows - row);
      const int fx = std::min(column, cross.cols - column);
      // The finest frequencies of a thumbnail are noise.
      const double fade = std::exp(-0.5 * (fx * fx + fy * fy) / (0.25 * kPatch * 0.25 * kPatch));
      const float norm = std::hypot(value[0], value[1]);
      value *= norm > 1e-6F ? static_cast<float>(fade / norm) : 0.0F;
    }
  }
  cv::dft(cross, surface, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT | cv::DFT_SCALE);
  const auto signed_of = [](int k) { return k > kPatch / 2 ? k - kPatch : k; };
  const auto value_at = [&](int row, int column) {
    return static_cast<double>(surface.at<float>((row + kPatch) % kPatch, (column + kPatch) % kPatch));
  };
  int best_row = 0, best_column = 0;
  double best = -1.0;
  for (int row = 0; row < kPatch; ++row) {
    for (int column = 0; column < kPatch; ++column) {
      if (std::hypot(signed_of(row), signed_of(column)) > reach_px || value_at(row, column) <= best) continue;
      best = value_at(row, column);
      best_row = row;
      best_column = column;
    }
  }
  double next = 1e-9;
  for (int row = 0; row < kPatch; ++row) {
    for (int column = 0; column < kPatch; ++column) {
      if (std::hypot(signed_of((row - best_row + kPatch) % kPatch),
                     signed_of((column - best_column + kPatch) % kPatch)) > kPeakRadius) {
        next = std::max(next, value_at(row, column));
      }
    }
  }
  const auto vertex = [](double before, double at, double after) {
    const double bend = before - 2.0 * at + after;
    return std::abs(bend) > 1e-12 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
  };
  Peak peak;
  peak.shift_px.x = signed_of(best_column) +
                    vertex(value_at(best_row, best_column - 1), best, value_at(best_row, best_column + 1));
  peak.shift_px.y = signed_of(best_row) +
                    vertex(value_at(best_row - 1, best_column), best, value_at(best_row + 1, best_column));
  peak.distinctness = best / next;
  return peak;
}

std::optional<Eigen::Vector2d> PixelOf(const View& view, const Eigen::Vector3d& point) {
  const Eigen::Vector3d in_cam = view.cam_from_enu * point;
  if (in_cam.z() < 1e-3) return std::nullopt;
  const Eigen::Vector2d pixel = view.intrinsics.ProjectBeyondFold(in_cam);
  return view.intrinsics.IsInImage(pixel) ? std::optional(pixel) : std::nullopt;
}

std::optional<Track> RegisterDirectly(const MatchedFlight& input, int first, int second,
                                      const Relief& relief) {
  if (!input.features[first] || !input.features[second]) return std::nullopt;
  Eigen::Vector3d middle_first, middle_second;
  const View& a = input.views[first];
  const View& b = input.views[second];
  if (!MeetGround(a, relief, a.intrinsics.MiddleOfCell(0, 0, 1), &middle_first)) return std::nullopt;
  if (!MeetGround(b, relief, b.intrinsics.MiddleOfCell(0, 0, 1), &middle_second)) return std::nullopt;
  Eigen::Vector3d place_in_enu = 0.5 * (middle_first + middle_second);
  place_in_enu.z() = relief.HeightAt(place_in_enu.head<2>());
  const double shorter_m = std::min(a.GsdM() * std::min(a.intrinsics.width_px, a.intrinsics.height_px),
                                    b.GsdM() * std::min(b.intrinsics.width_px, b.intrinsics.height_px));
  const double cell_m = kPatchShare * shorter_m / kPatch;
  const double reach_px = std::min(
      0.3 * kPatch,
      kSigmas * std::hypot(input.ground_sigma_m[first], input.ground_sigma_m[second]) / cell_m + 2.0);

  const Patch fixed = ProjectThumbnail(input, first, place_in_enu, cell_m);
  const Patch moving = ProjectThumbnail(input, second, place_in_enu, cell_m);
  if (fixed.inside < kMinInside || moving.inside < kMinInside) return std::nullopt;
  cv::Scalar mean, deviation;
  for (const Patch* patch : {&fixed, &moving}) {
    cv::meanStdDev(patch->grey, mean, deviation);
    if (deviation[0] < kMinContrast) return std::nullopt;
  }
  const Peak peak = CorrelatePhase(fixed.grey, moving.grey, reach_px);
  if (peak.distinctness < kMinDistinctness) return std::nullopt;
  const Eigen::Vector2d shift_m(peak.shift_px.x * cell_m, -peak.shift_px.y * cell_m);
  const Patch again =
      ProjectThumbnail(input, second, place_in_enu + Eigen::Vector3d(shift_m.x(), shift_m.y(), 0.0), cell_m);
  if (again.inside < kMinInside) return std::nullopt;
  const Peak left_over = CorrelatePhase(fixed.grey, again.grey, reach_px);
  if (left_over.distinctness < kMinDistinctness ||
      std::hypot(left_over.shift_px.x, left_over.shift_px.y) > kLeftOverPx) {
    return std::nullopt;
  }
  // The second shows it this much further east and north.
  const Eigen::Vector2d apart_m =
      shift_m + Eigen::Vector2d(left_over.shift_px.x * cell_m, -left_over.shift_px.y * cell_m);
  const auto in_first = PixelOf(a, place_in_enu);
  const auto in_second = PixelOf(b, place_in_enu + Eigen::Vector3d(apart_m.x(), apart_m.y(), 0.0));
  if (!in_first || !in_second) return std::nullopt;
  const double sigma_m = 1.5 * cell_m;
  Track track;
  track.point_in_enu = place_in_enu;
  track.observations = {{first, *in_first, sigma_m / a.GsdM()}, {second, *in_second, sigma_m / b.GsdM()}};
  return track;
}

}  // namespace

std::vector<Track> DirectTracks(const MatchedFlight& input, const Relief& relief, int threads) {
  const std::vector<int> linked = CountPairs(input.views.size(), input.links);
  return ParallelCollect(input.pairs.size(), threads, [&](std::size_t p) -> std::optional<Track> {
    const PhotoPair& pair = input.pairs[p];
    if (pair.overlap < kMinOverlap) return std::nullopt;
    if (linked[pair.first] >= kEnoughPairs && linked[pair.second] >= kEnoughPairs) return std::nullopt;
    return RegisterDirectly(input, pair.first, pair.second, relief);
  });
}

bool Agrees(const std::vector<View>& views, const Track& tie) {
  return std::all_of(tie.observations.begin(), tie.observations.end(), [&](const Observation& one) {
    return ReprojectionErrorPx(views[one.photo], one, tie.point_in_enu) < 2.0 * one.sigma_px;
  });
}

std::vector<int> CountTies(const std::vector<View>& views, const std::vector<Track>& ties) {
  std::vector<int> counts(views.size(), 0);
  for (const Track& tie : ties) {
    if (!Agrees(views, tie)) continue;
    for (const Observation& one : tie.observations) ++counts[one.photo];
  }
  return counts;
}

}  // namespace skyquilt::alignment
