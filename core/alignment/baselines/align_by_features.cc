#include "core/alignment/baselines/align_by_features.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "core/alignment/baselines/align_by_pose.h"
#include "core/alignment/baselines/chain_homographies.h"
#include "core/alignment/bundle/reprojection_cost.h"
#include "core/alignment/estimators/plane_homography.h"
#include "core/alignment/features/features.h"
#include "core/alignment/matching/verified_pair.h"
#include "core/alignment/scene/matches.h"
#include "core/base/scoped_timer.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::alignment {
namespace {

using Complex = std::complex<double>;

constexpr int kPixelsAcross = 5;

// The mosaic's y runs down, north runs up.
Complex Upright(const Eigen::Vector2d& place_in_mosaic) {
  return {place_in_mosaic.x(), -place_in_mosaic.y()};
}

// Each component on its photos' recorded positions, as if all looked straight down. A single photo is not
// placed.
std::map<int, GroundSimilarity> PlaceComponents(const poses::PosedFlight& posed,
                                                const ChainedMosaic& mosaic) {
  std::map<int, std::vector<std::pair<Complex, Complex>>> places;
  for (std::size_t i = 0; i < posed.photos.size(); ++i) {
    const ChainedPhoto& photo = mosaic.photos[i];
    if (photo.component < 0) continue;
    const Eigen::Vector3d center = posed.photos[i].cam_from_enu.TargetOriginInSource();
    places[photo.component].emplace_back(Upright(photo.mosaic_from_photo.col(2).hnormalized()),
                                         Complex(center.x(), center.y()));
  }
  std::map<int, GroundSimilarity> placed;
  for (const auto& [component, of_component] : places) {
    if (of_component.size() < 2) continue;
    const GroundSimilarity similarity = FitSimilarity(of_component);
    if (std::abs(similarity.turn_and_scale) > 1e-9) placed[component] = similarity;
  }
  return placed;
}

struct Resected {
  geo::Rigid3 cam_from_enu;
  double misfit_px = 0.0;
};

// The camera that comes nearest to showing the ground as the homography has it.
std::optional<Resected> Resect(const camera::Intrinsics& lens, const ChainedPhoto& photo,
                               const GroundSimilarity& ground_from_mosaic, double ground_z_m) {
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector3d>> seen;
  const auto meet = [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector3d> {
    const auto place = MapPlace(photo.mosaic_from_photo, PlaceInPhoto(lens, pixel));
    if (!place) return std::nullopt;
    const Complex ground = ground_from_mosaic * Upright(*place);
    return Eigen::Vector3d(ground.real(), ground.imag(), ground_z_m);
  };
  for (int row = 0; row < kPixelsAcross; ++row) {
    for (int column = 0; column < kPixelsAcross; ++column) {
      const Eigen::Vector2d pixel = lens.MiddleOfCell(column, row, kPixelsAcross);
      const auto point = meet(pixel);
      if (!point) return std::nullopt;
      seen.emplace_back(pixel, *point);
    }
  }
  // From straight above, as high as the scale at the axis says.
  const Eigen::Vector2d axis(lens.center_x_px, lens.center_y_px);
  const auto middle = meet(axis), beside = meet(axis + Eigen::Vector2d(10.0, 0.0));
  if (!middle || !beside) return std::nullopt;
  const Eigen::Vector3d step = (*beside - *middle) / 10.0;
  const double gsd_m = step.norm();
  if (gsd_m < 1e-6) return std::nullopt;
  Eigen::Matrix3d rotation;
  rotation.row(0) = step.transpose() / gsd_m;
  rotation.row(2) = -Eigen::RowVector3d::UnitZ();
  rotation.row(1) = rotation.row(2).cross(rotation.row(0));
  const Eigen::Vector3d center = *middle + Eigen::Vector3d(0.0, 0.0, gsd_m * lens.MeanFocalPx());

  const auto start = geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond(rotation), center);
  double pose[kPoseSize] = {};
  double as_recorded[kLensSize] = {0.0, 0.0, 0.0, lens.k1, lens.k2, lens.p1, lens.p2};
  ceres::Problem problem;
  const std::shared_ptr<const CameraStart> camera = StartOf(start, {}, lens);
  for (auto& [pixel, point] : seen) {
    problem.AddResidualBlock(MakeReprojectionCost(camera, pixel, 1.0), nullptr, pose, point.data(),
                             as_recorded);
    problem.SetParameterBlockConstant(point.data());
  }
  problem.SetParameterBlockConstant(as_recorded);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;
  Resected resected;
  resected.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      (geo::RotationFromVector({pose[0], pose[1], pose[2]}) * Eigen::Quaterniond(rotation)).normalized(),
      center + Eigen::Vector3d(pose[3], pose[4], pose[5]));
  resected.misfit_px = std::sqrt(2.0 * summary.final_cost / static_cast<double>(seen.size()));
  if (resected.cam_from_enu.TargetOriginInSource().z() <= ground_z_m) return std::nullopt;
  return resected;
}

flight::Remark HowChained(const ChainedPhoto& chained, double misfit_px) {
  if (chained.links == 0) return {flight::RemarkCode::kFirstOfChain, {{"misfit_px", misfit_px}}};
  return {flight::RemarkCode::kChained, {{"photos", chained.links}, {"misfit_px", misfit_px}}};
}

}  // namespace

Result<AlignedFlight> AlignByFeatures(const poses::PosedFlight& posed, const flight::PhotoSource& source,
                                      const AlignOptions& options, AlignReport& report, Progress& progress) {
  report = {};
  ScopedTimer total_timer(report.total_s);
  const Photographed photographed =
      ExtractAll(posed, source, options.features, {}, options.threads, 0.7, progress);
  std::vector<camera::Intrinsics> lenses;
  for (const poses::PosedPhoto& photo : posed.photos) lenses.push_back(photo.photo.intrinsics);
  ChainedMosaic mosaic;
  {
    ScopedTimer timer(report.matching_s);
    mosaic = ChainHomographies(photographed.Readable(), lenses, options.threads, progress);
  }
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The alignment was cancelled.", ""};

  report.photos = static_cast<int>(posed.photos.size());
  report.pairs_tried = mosaic.pairs_tried;
  report.pairs_linked = mosaic.pairs_linked;
  report.solver = "chained homographies";
  const std::map<int, GroundSimilarity> components = PlaceComponents(posed, mosaic);
  AlignedFlight flight = WithoutPhotos(posed);
  double square_px = 0.0;
  for (std::size_t i = 0; i < posed.photos.size(); ++i) {
    const poses::PosedPhoto& before = posed.photos[i];
    const ChainedPhoto& chained = mosaic.photos[i];
    report.decode_s += photographed.features[i].decode_s;
    report.features_s += photographed.features[i].detect_s;
    const auto component = components.find(chained.component);
    std::optional<Resected> resected;
    if (component != components.end()) {
      resected = Resect(before.photo.intrinsics, chained, component->second, posed.ground_z_in_enu_m);
    }
    if (!resected) {
      const std::string& unreadable = photographed.unreadable[i];
      flight.left_out.push_back({before.photo.name, ErrorCode::kUnprocessable,
                                 !unreadable.empty()             ? flight::Remark(unreadable)
                                 : component == components.end() ? flight::RemarkCode::kLeftNoFeaturesMatch
                                                                 : flight::RemarkCode::kLeftBentByChain});
      continue;
    }
    AlignedPhoto photo{
        .photo = before.photo,
        .intrinsics = before.photo.intrinsics,
        .cam_from_enu = resected->cam_from_enu,
        .readout_motion = {},
        .placement = Placement::kAligned,
        .placement_remarks = {HowChained(chained, resected->misfit_px)},
        .error_radius_m = before.error_radius_m,
        .height_above_ground_m = resected->cam_from_enu.TargetOriginInSource().z() - posed.ground_z_in_enu_m,
        .sharpness = {}};
    report.photo_reports.push_back(
        {.name = before.photo.name,
         .placement = photo.placement,
         .remarks = photo.placement_remarks,
         .features = static_cast<int>(photographed.features[i].keypoints.size()),
         .links = chained.links,
         .observations = chained.inliers,
         .residual_rms_px = chained.inliers > 0 ? std::sqrt(chained.square_px / chained.inliers) : 0.0,
         .faults = {}});
    square_px += chained.square_px;
    report.observations += chained.inliers;
    flight.photos.push_back(std::move(photo));
  }
  report.aligned = static_cast<int>(flight.photos.size());
  report.components = static_cast<int>(components.size());
  report.residual_rms_px = report.observations > 0 ? std::sqrt(square_px / report.observations) : 0.0;
  if (flight.photos.empty()) {
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailNoFeaturesMatch);
  }
  if (report.components > 1) {
    flight.warnings.push_back({flight::RemarkCode::kGroupsOfFeatures, {{"groups", report.components}}});
  }
  progress.Report(1.0, "aligned");
  return flight;
}

}  // namespace skyquilt::alignment
