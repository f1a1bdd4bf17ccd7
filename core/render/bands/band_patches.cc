#include "core/render/bands/band_patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace skyquilt::render {
namespace {

// Smaller patches where few pixels are; spread so that there are about as many as wanted.
struct PatchSize {
  int patch_px, step_px;
};
PatchSize SizeOf(const PatchSearch& search, const cv::Mat1f& picture) {
  const int patch_px = search.denominator == 4 ? 40 : search.denominator == 2 ? 56 : 48;
  const double pixels = picture.cols * static_cast<double>(picture.rows);
  const int step_px = static_cast<int>(std::sqrt(pixels / search.patches));
  return {patch_px, std::clamp(step_px, patch_px / 2, 2 * patch_px)};
}
constexpr float kMinCorrelation = 0.4F;
constexpr int kFilterPx = 3;  // at the picture's edge nothing but the edge is seen

cv::Mat1f EdgesOf(const cv::Mat1f& picture) {
  cv::Mat1f smooth, dx, dy, edges;
  constexpr double kSigmaPx = 1.0;
  cv::GaussianBlur(picture, smooth, {}, kSigmaPx);
  cv::Sobel(smooth, dx, CV_32F, 1, 0);
  cv::Sobel(smooth, dy, CV_32F, 0, 1);
  cv::magnitude(dx, dy, edges);
  cv::sqrt(edges, edges);  // one strong edge must not be the whole patch
  return edges;
}

// Where the ray of a pixel meets the ground, in the camera's frame.
std::optional<Eigen::Vector3d> GroundInCam(const alignment::AlignedPhoto& photo,
                                           const ground::GroundSurface& ground,
                                           const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d in_cam = photo.intrinsics.Unproject(pixel);
  const Eigen::Vector3d ray = photo.cam_from_enu.rotation.conjugate() * in_cam;
  const Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
  constexpr double kMinSlope = 0.2;  // towards the horizon patches are no squares
  if (!(-ray.z() > kMinSlope * ray.norm())) return std::nullopt;
  double z_m = ground.MeanHeight(), depth = 0.0;
  constexpr int kSteps = 6;
  for (int i = 0; i < kSteps; ++i) {
    depth = (z_m - center.z()) / ray.z();
    if (!(depth > 0.0)) return std::nullopt;
    z_m = ground.HeightAt((center + depth * ray).head<2>());
  }
  return depth * in_cam;
}

// The place of the highest of three values around the middle one.
double PeakOf(double before, double at, double after) {
  const double bend = before - 2.0 * at + after;
  return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

// A pixel of the full-size picture at a smaller size and back: centres carry the half pixel.
double Smaller(double at, int denominator) { return (at + 0.5) / denominator - 0.5; }
double Larger(double at, int denominator) { return (at + 0.5) * denominator - 0.5; }

}  // namespace

struct BandEdges::Levels {
  std::array<cv::Mat1f, 3> edges;  // at 1/1, 1/2, 1/4
  cv::Mat1f& At(int denominator) { return edges[denominator == 4 ? 2 : denominator == 2 ? 1 : 0]; }
  const cv::Mat1f& At(int denominator) const { return const_cast<Levels*>(this)->At(denominator); }
};

BandEdges::BandEdges(const image::SampleImage& picture, int from, int to)
    : levels_(std::make_unique<Levels>()) {
  const cv::Mat stored(picture.height_px, picture.width_px, CV_16UC1,
                       const_cast<std::uint16_t*>(picture.samples.data()));
  cv::Mat1f level;
  stored.convertTo(level, CV_32F, 1.0 / 65536.0);
  for (int denominator = 1; denominator <= to; denominator *= 2) {
    if (denominator >= from) levels_->At(denominator) = EdgesOf(level);
    if (denominator == to) break;
    cv::Mat1f smaller;
    // Sides that are odd lose a row: the same scale in both directions.
    const cv::Rect even(0, 0, std::max(2, level.cols / 2 * 2), std::max(2, level.rows / 2 * 2));
    if (level.cols < 2 || level.rows < 2) continue;
    cv::resize(level(even), smaller, {even.width / 2, even.height / 2}, 0, 0, cv::INTER_AREA);
    level = smaller;
  }
}
BandEdges::~BandEdges() = default;
BandEdges::BandEdges(BandEdges&&) noexcept = default;

BandMeasurement MeasureBand(const alignment::AlignedPhoto& reference, const BandEdges& reference_edges,
                            const alignment::AlignedPhoto& band, const PixelField& field,
                            const BandEdges& band_edges, const ground::GroundSurface& ground,
                            const PatchSearch& search) {
  const int denominator = search.denominator, reach_px = search.reach_px;
  const cv::Mat1f& from = reference_edges.levels().At(denominator);
  const cv::Mat1f& to = band_edges.levels().At(denominator);
  BandMeasurement measured;
  const geo::Rigid3 band_from_reference = band.cam_from_enu * reference.cam_from_enu.Inverse();
  // Where the band shows what the reference shows at a pixel of its smaller size; smaller pixels too.
  const auto shown_at = [&](double x, double y, Eigen::Vector3d* in_cam) -> std::optional<Eigen::Vector2d> {
    const auto point = GroundInCam(reference, ground, {Larger(x, denominator), Larger(y, denominator)});
    if (!point) return std::nullopt;
    if (in_cam != nullptr) *in_cam = *point;
    const auto pixel = band.intrinsics.Project(band_from_reference * *point);
    if (!pixel) return std::nullopt;
    const Eigen::Vector2d at = *pixel + field.At(*pixel);
    return Eigen::Vector2d(Smaller(at.x(), denominator), Smaller(at.y(), denominator));
  };
  const auto [patch_px, step_px] = SizeOf(search, from);
  const int half = patch_px / 2, searched = patch_px + 2 * reach_px;
  const int first = half + kFilterPx;
  cv::Mat1f patch, correlation;
  for (int y = first; y + first <= from.rows; y += step_px) {
    for (int x = first; x + first <= from.cols; x += step_px) {
      ++measured.looked_at;
      const auto middle = shown_at(x, y, nullptr);
      const auto right = shown_at(x + half, y, nullptr), below = shown_at(x, y + half, nullptr);
      if (!middle || !right || !below) continue;
      Eigen::Matrix2d step;  // of the band's pixels, a pixel of the reference's
      step << (*right - *middle) / half, (*below - *middle) / half;
      const double corner = -half - reach_px;
      const Eigen::Vector2d origin = *middle + step * Eigen::Vector2d(corner, corner);
      const Eigen::Vector2d far_side = step.cwiseAbs() * Eigen::Vector2d(searched, searched);
      if (origin.minCoeff() < kFilterPx || origin.x() + far_side.x() > to.cols - kFilterPx ||
          origin.y() + far_side.y() > to.rows - kFilterPx)
        continue;
      const cv::Matx23d warp(step(0, 0), step(0, 1), origin.x(), step(1, 0), step(1, 1), origin.y());
      cv::warpAffine(to, patch, warp, {searched, searched}, cv::INTER_CUBIC | cv::WARP_INVERSE_MAP);
      cv::matchTemplate(patch, from(cv::Rect(x - half, y - half, patch_px, patch_px)), correlation,
                        cv::TM_CCOEFF_NORMED);
      double best = 0.0;
      cv::Point at;
      cv::minMaxLoc(correlation, nullptr, &best, nullptr, &at);
      if (!(best > kMinCorrelation) || at.x == 0 || at.y == 0 || at.x + 1 == correlation.cols ||
          at.y + 1 == correlation.rows)
        continue;
      const Eigen::Vector2d shift(
          at.x - reach_px + PeakOf(correlation(at.y, at.x - 1), best, correlation(at.y, at.x + 1)),
          at.y - reach_px + PeakOf(correlation(at.y - 1, at.x), best, correlation(at.y + 1, at.x)));
      BandSighting sighting;
      // The patch lies around (x - 0.5, y - 0.5): an even number of pixels has no middle one.
      const auto expected = shown_at(x - 0.5, y - 0.5, &sighting.in_reference_cam);
      if (!expected) continue;
      const Eigen::Vector2d found = *expected + step * shift;
      sighting.pixel_in_band = {Larger(found.x(), denominator), Larger(found.y(), denominator)};
      measured.sightings.push_back(sighting);
    }
  }
  return measured;
}

}  // namespace skyquilt::render
