#include "core/alignment/bundle_adjustment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/alignment/residuals.h"

namespace skyquilt::alignment {
namespace {

using PoseBlock = std::array<double, kPoseSize>;
using LensBlock = std::array<double, kLensSize>;

constexpr double kLossSigmas = 2.5;
constexpr double kReferenceWidthPx = 4000.0;
constexpr int kDenseUpToPhotos = 25;

camera::Intrinsics Applied(const camera::Intrinsics& start, const LensBlock& lens) {
  camera::Intrinsics applied = start;
  applied.focal_x_px *= std::exp(lens[0]);
  applied.focal_y_px *= std::exp(lens[0]);
  applied.center_x_px += lens[1];
  applied.center_y_px += lens[2];
  applied.k1 = lens[3];
  applied.k2 = lens[4];
  applied.p1 = lens[5];
  applied.p2 = lens[6];
  return applied;
}

geo::Rigid3 Applied(const geo::Rigid3& start, const PoseBlock& pose) {
  const Eigen::Vector3d turn(pose[0], pose[1], pose[2]);
  const Eigen::Quaterniond rotation = (geo::RotationFromVector(turn) * start.rotation).normalized();
  return geo::Rigid3::FromRotationAndTargetOrigin(
      rotation, start.TargetOriginInSource() + Eigen::Vector3d(pose[3], pose[4], pose[5]));
}

// Drops what lies too far off, and points that then hang on one ray; returns the number dropped.
int DropOutliers(const std::vector<View>& views, double cut_px, std::vector<Track>& tracks) {
  int dropped = 0;
  for (Track& track : tracks) {
    auto& seen = track.observations;
    const std::size_t before = seen.size();
    std::erase_if(seen, [&](const Observation& one) {
      const double scale = views[one.photo].intrinsics.width_px / kReferenceWidthPx;
      const double cut = std::max(cut_px * scale, 3.5 * one.sigma_px);
      return ReprojectionErrorPx(views[one.photo], one, track.point_in_enu) > cut;
    });
    dropped += static_cast<int>(before - seen.size());
  }
  std::erase_if(tracks, [](const Track& track) { return track.observations.size() < 2; });
  return dropped;
}

// One solve from the problem's present state, which becomes the solution.
class Round {
 public:
  Round(BundleProblem& problem, const std::vector<camera::Intrinsics>& recorded, const BundleOptions& options)
      : bundle_(problem),
        recorded_(recorded),
        options_(options),
        poses_(problem.photos.size(), PoseBlock{}),
        lenses_(problem.lenses.size()),
        biases_(problem.lines, std::array<double, 3>{}) {}

  void Solve(std::vector<Eigen::Vector3d>& line_bias, BundleSummary& summary) {
    for (std::size_t l = 0; l < biases_.size(); ++l) {
      for (int k = 0; k < 3; ++k) biases_[l][k] = line_bias[l][k];
    }
    std::vector<char> in_use(poses_.size(), 0);
    for (const auto* list : {&bundle_.tracks, &bundle_.soft_tracks}) {
      for (const Track& track : *list) {
        for (const Observation& seen : track.observations) in_use[seen.photo] = 1;
      }
    }
    AddLenses();
    AddObservations();
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (in_use[i]) AddPriors(i);
    }
    for (auto& bias : biases_) {
      if (!ceres_.HasParameterBlock(bias.data())) continue;
      PriorResidual<3> prior{Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(bundle_.sigma_line_bias_rad)};
      ceres_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PriorResidual<3>, 3, 3>(new PriorResidual<3>(prior)), nullptr,
          bias.data());
    }
    ceres::Solver::Options options;
    const int active = static_cast<int>(std::count(in_use.begin(), in_use.end(), 1));
    options.linear_solver_type = active <= kDenseUpToPhotos ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.max_num_iterations = options_.max_iterations;
    options.function_tolerance = 1e-5;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    options.linear_solver_ordering.reset(ordering_);
    ordering_ = nullptr;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (in_use[i]) options.linear_solver_ordering->AddElementToGroup(poses_[i].data(), 1);
    }
    for (auto& lens : lenses_) {
      if (ceres_.HasParameterBlock(lens.data()))
        options.linear_solver_ordering->AddElementToGroup(lens.data(), 1);
    }
    for (auto& bias : biases_) {
      if (ceres_.HasParameterBlock(bias.data()))
        options.linear_solver_ordering->AddElementToGroup(bias.data(), 1);
    }
    ceres::Solver::Summary solved;
    ceres::Solve(options, &ceres_, &solved);
    summary.iterations += static_cast<int>(solved.iterations.size());
    summary.solver = active <= kDenseUpToPhotos ? "dense_schur" : "sparse_schur";
    if (options_.estimate_lens_sigma) EstimateLensSigma();
    TakeOver(line_bias);
  }

 private:
  void AddLenses() {
    for (std::size_t c = 0; c < lenses_.size(); ++c) {
      const camera::Intrinsics& now = bundle_.lenses[c].intrinsics;
      const camera::Intrinsics& was = recorded_[c];
      lenses_[c] = {std::log(now.focal_x_px / was.focal_x_px),
                    now.center_x_px - was.center_x_px,
                    now.center_y_px - was.center_y_px,
                    now.k1,
                    now.k2,
                    now.p1,
                    now.p2};
    }
  }

  void AddObservations() {
    ordering_ = new ceres::ParameterBlockOrdering;
    for (auto* list : {&bundle_.tracks, &bundle_.soft_tracks}) {
      for (Track& track : *list) {
        for (const Observation& seen : track.observations) AddObservation(track, seen);
        ordering_->AddElementToGroup(track.point_in_enu.data(), 0);
      }
    }
    for (Track& track : bundle_.soft_tracks) {
      const double height = bundle_.photos[track.observations.front().photo].height_above_ground_m;
      ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<PointHeightResidual, 1, 3>(
                                  new PointHeightResidual{bundle_.ground_z_in_enu_m, 0.03 * height}),
                              nullptr, track.point_in_enu.data());
    }
    for (std::size_t c = 0; c < lenses_.size(); ++c) {
      if (!ceres_.HasParameterBlock(lenses_[c].data())) continue;
      if (!options_.adjust_lens) {
        ceres_.SetParameterBlockConstant(lenses_[c].data());
        continue;
      }
      const BundleLens& lens = bundle_.lenses[c];
      PriorResidual<kLensSize> prior;
      prior.expected << 0.0, 0.0, 0.0, recorded_[c].k1, recorded_[c].k2, recorded_[c].p1, recorded_[c].p2;
      prior.sigma << lens.sigma_focal_share, lens.sigma_center_px, lens.sigma_center_px, lens.sigma_k1,
          lens.sigma_k2, lens.sigma_p, lens.sigma_p;
      ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<PriorResidual<kLensSize>, kLensSize, kLensSize>(
                                  new PriorResidual<kLensSize>(prior)),
                              nullptr, lenses_[c].data());
    }
  }

  void AddObservation(Track& track, const Observation& seen) {
    const BundlePhoto& photo = bundle_.photos[seen.photo];
    const camera::Intrinsics& lens = recorded_[photo.lens];
    auto* residual = new ReprojectionResidual{photo.cam_from_enu.rotation.toRotationMatrix(),
                                              photo.cam_from_enu.TargetOriginInSource(),
                                              {lens.focal_x_px, lens.focal_y_px},
                                              {lens.center_x_px, lens.center_y_px},
                                              seen.pixel_in_image,
                                              seen.sigma_px};
    ceres_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ReprojectionResidual, 2, kPoseSize, 3, kLensSize>(residual),
        new ceres::CauchyLoss(kLossSigmas), poses_[seen.photo].data(), track.point_in_enu.data(),
        lenses_[photo.lens].data());
  }

  void AddPriors(std::size_t i) {
    const BundlePhoto& photo = bundle_.photos[i];
    const Eigen::Vector3d turned = geo::VectorFromRotation(
        (photo.cam_from_enu.rotation * photo.prior_cam_from_enu.rotation.conjugate()).normalized());
    const Eigen::Vector3d moved =
        photo.cam_from_enu.TargetOriginInSource() - photo.prior_cam_from_enu.TargetOriginInSource();
    ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<AttitudeResidual, 3, kPoseSize, 3>(
                                new AttitudeResidual{turned, photo.sigma_attitude_rad}),
                            new ceres::HuberLoss(3.0), poses_[i].data(), biases_[photo.line].data());
    ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<PositionResidual, 3, kPoseSize>(
                                new PositionResidual{moved, photo.sigma_position_m}),
                            new ceres::HuberLoss(3.0), poses_[i].data());
  }

  void EstimateLensSigma() {
    std::vector<std::pair<const double*, const double*>> blocks;
    for (auto& lens : lenses_) {
      if (ceres_.HasParameterBlock(lens.data()) && !ceres_.IsParameterBlockConstant(lens.data())) {
        blocks.emplace_back(lens.data(), lens.data());
      }
    }
    if (blocks.empty()) return;
    ceres::Covariance::Options options;
    options.num_threads = 1;
    ceres::Covariance covariance(options);
    if (!covariance.Compute(blocks, &ceres_)) return;
    for (std::size_t c = 0; c < lenses_.size(); ++c) {
      Eigen::Matrix<double, kLensSize, kLensSize, Eigen::RowMajor> block;
      if (!ceres_.HasParameterBlock(lenses_[c].data()) ||
          !covariance.GetCovarianceBlock(lenses_[c].data(), lenses_[c].data(), block.data())) {
        continue;
      }
      bundle_.lenses[c].found_sigma_focal_px =
          std::sqrt(std::max(0.0, block(0, 0))) * recorded_[c].focal_x_px;
    }
  }

  void TakeOver(std::vector<Eigen::Vector3d>& line_bias) {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      bundle_.photos[i].cam_from_enu = Applied(bundle_.photos[i].cam_from_enu, poses_[i]);
    }
    for (std::size_t c = 0; c < lenses_.size(); ++c) {
      bundle_.lenses[c].intrinsics = Applied(recorded_[c], lenses_[c]);
    }
    for (std::size_t l = 0; l < biases_.size(); ++l) {
      line_bias[l] = Eigen::Vector3d(biases_[l][0], biases_[l][1], biases_[l][2]);
    }
  }

  BundleProblem& bundle_;
  const std::vector<camera::Intrinsics>& recorded_;
  const BundleOptions& options_;
  std::vector<PoseBlock> poses_;
  std::vector<LensBlock> lenses_;
  std::vector<std::array<double, 3>> biases_;
  ceres::Problem ceres_;
  ceres::ParameterBlockOrdering* ordering_ = nullptr;
};

}  // namespace

std::vector<View> ViewsOf(const BundleProblem& problem) {
  std::vector<View> views;
  views.reserve(problem.photos.size());
  for (const BundlePhoto& photo : problem.photos) {
    views.push_back({problem.lenses[photo.lens].intrinsics, photo.cam_from_enu, photo.height_above_ground_m});
  }
  return views;
}

BundleSummary AdjustBundle(BundleProblem& problem, const BundleOptions& options) {
  BundleSummary summary;
  summary.line_bias_rad.assign(problem.lines, Eigen::Vector3d::Zero());
  std::vector<camera::Intrinsics> recorded;
  for (const BundleLens& lens : problem.lenses) recorded.push_back(lens.recorded);
  BundleOptions round_options = options;
  for (std::size_t round = 0; round < options.cuts_px.size(); ++round) {
    round_options.estimate_lens_sigma = options.estimate_lens_sigma && round + 1 == options.cuts_px.size();
    Round(problem, recorded, round_options).Solve(summary.line_bias_rad, summary);
    summary.dropped += DropOutliers(ViewsOf(problem), options.cuts_px[round], problem.tracks);
  }
  const std::vector<View> views = ViewsOf(problem);
  double square = 0.0;
  for (Track& track : problem.tracks) {
    const Eigen::Vector3d adjusted = track.point_in_enu;
    Triangulate(views, track);  // for the angle alone: the adjusted point is the better one
    track.point_in_enu = adjusted;
    for (const Observation& seen : track.observations) {
      const double miss = ReprojectionErrorPx(views[seen.photo], seen, track.point_in_enu);
      square += miss * miss;
      ++summary.observations;
    }
  }
  summary.rms_px = summary.observations > 0 ? std::sqrt(square / summary.observations) : 0.0;
  return summary;
}

}  // namespace skyquilt::alignment
