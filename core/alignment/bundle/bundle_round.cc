#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/bundle/reprojection_cost.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

constexpr std::size_t kBiasSize = 3;
constexpr std::size_t kPointSize = 3;
constexpr std::size_t kReadoutSize = 1;
constexpr std::size_t kClockSize = 1;
using OneNumber = Eigen::Matrix<double, 1, 1>;

constexpr double kLossSigmas = 2.5;
constexpr std::size_t kDenseUpToPhotos = 25;
constexpr double kControlLossSigmas = 5.0;
constexpr double kPositionBiasSigmaM =
    30.0;  // of consumer GNSS in a bad hour, and of a wrong reference system
constexpr double kSigmaLineBiasRad = 0.05;
constexpr double kSigmaReadoutS = 0.05;
constexpr double kHeldSigma = 1e-9;
constexpr double kUnknownHeightSigmaM = 1000.0;
constexpr double kReliefShare = 0.03;  // of the flying height: how near the ground a soft tie lies

camera::Intrinsics Applied(const camera::Intrinsics& start, const double* lens) {
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

geo::Rigid3 Applied(const geo::Rigid3& start, const double* pose) {
  const Eigen::Vector3d turn(pose[0], pose[1], pose[2]);
  const Eigen::Quaterniond rotation = (geo::RotationFromVector(turn) * start.rotation).normalized();
  return geo::Rigid3::FromRotationAndTargetOrigin(
      rotation, start.TargetOriginInSource() + Eigen::Vector3d(pose[3], pose[4], pose[5]));
}

// A cost term with automatic derivatives: residuals, then the sizes of the blocks that it hangs on.
template <int kResiduals, int... kBlocks, typename Residual>
ceres::CostFunction* Derived(const Residual& residual) {
  return new ceres::AutoDiffCostFunction<Residual, kResiduals, kBlocks...>(new Residual(residual));
}

// One solve from the problem's present state, which becomes the solution where there is a usable one.
class Round {
 public:
  Round(BundleProblem& problem, const BundleOptions& options)
      : bundle_(problem),
        options_(options),
        first_lens_(kPoseSize * problem.photos.size()),
        first_bias_(first_lens_ + kLensSize * problem.lenses.size()),
        position_bias_(first_bias_ + kBiasSize * problem.lines),
        first_point_(position_bias_ + kBiasSize),
        first_correction_(first_point_ + kPointSize * (problem.tracks.size() + problem.soft_tracks.size() +
                                                       problem.control.size())),
        first_readout_(first_correction_ + kCorrectionSize * problem.photos.size()),
        clock_(first_readout_ + kReadoutSize * problem.lenses.size()),
        state_(clock_ + kClockSize, 0.0),
        starts_(problem.photos.size()) {
    for (auto* list : {&bundle_.tracks, &bundle_.soft_tracks}) {
      for (Track& track : *list) points_.push_back(&track);
    }
    for (BundleControl& tied : bundle_.control) points_.push_back(&tied.track);
  }

  void Solve(std::vector<Eigen::Vector3d>& line_bias, BundleSummary& summary) {
    for (int l = 0; l < bundle_.lines; ++l) Eigen::Map<Eigen::Vector3d>(Bias(l)) = line_bias[l];
    AddObservations();
    AddLenses();
    AddControl();
    std::vector<std::size_t> in_use;  // photos that see anything
    for (std::size_t i = 0; i < bundle_.photos.size(); ++i) {
      if (ceres_.HasParameterBlock(Pose(i))) in_use.push_back(i);
    }
    AddPlane(in_use.size());
    for (const std::size_t i : in_use) {
      AddPriors(i);
      if (bundle_.photos[i].is_fixed) ceres_.SetParameterBlockConstant(Pose(i));
      if (ceres_.HasParameterBlock(Correction(i))) AddCorrectionPrior(i);
    }
    AddPositionBias();
    AddClock();
    for (int l = 0; l < bundle_.lines; ++l) {
      if (!ceres_.HasParameterBlock(Bias(l))) continue;
      AddPrior<kBiasSize>({Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(kSigmaLineBiasRad)}, Bias(l));
    }
    ceres::Solver::Options options;
    const bool is_dense = in_use.size() <= kDenseUpToPhotos;
    options.linear_solver_type = is_dense ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.max_num_iterations = options_.max_iterations;
    options.function_tolerance = 1e-5;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    // Points are eliminated first.
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    std::vector<double*> blocks;
    ceres_.GetParameterBlocks(&blocks);
    for (double* block : blocks) {
      const bool is_point = block >= Point(0) && block < Point(points_.size());
      options.linear_solver_ordering->AddElementToGroup(block, is_point ? 0 : 1);
    }
    ceres::Solver::Summary solved;
    const TraceSpan span("adjust");
    ceres::Solve(options, &ceres_, &solved);
    summary.iterations += static_cast<int>(solved.iterations.size());
    summary.solver = is_dense ? "dense_schur" : "sparse_schur";
    summary.has_failed = !solved.IsSolutionUsable();
    if (summary.has_failed) {
      summary.solver += " (failed: " + solved.message + ")";
      return;
    }
    if (options_.estimate_lens_sigma) EstimateLensSigma();
    ReadBack(line_bias);
  }

 private:
  template <int kSize>
  void AddPrior(const PriorResidual<kSize>& prior, double* block, ceres::LossFunction* loss = nullptr) {
    ceres_.AddResidualBlock(Derived<kSize, kSize>(prior), loss, block);
  }

  void AddObservations() {
    for (std::size_t n = 0; n < points_.size() - bundle_.control.size(); ++n) AddPoint(n);
    for (std::size_t t = 0; t < bundle_.soft_tracks.size(); ++t) {
      const double height =
          bundle_.photos[bundle_.soft_tracks[t].observations.front().photo].height_above_ground_m;
      AddPlaneOf({bundle_.ground_z_in_enu_m, 0.0, 0.0, kReliefShare * height}, bundle_.tracks.size() + t);
    }
  }

  void AddLenses() {
    for (std::size_t c = 0; c < bundle_.lenses.size(); ++c) {
      const BundleLens& lens = bundle_.lenses[c];
      const camera::Intrinsics& now = lens.intrinsics;
      const camera::Intrinsics& was = lens.recorded;
      Eigen::Map<Eigen::Matrix<double, kLensSize, 1>> state(Lens(c));
      state << std::log(now.focal_x_px / was.focal_x_px), now.center_x_px - was.center_x_px,
          now.center_y_px - was.center_y_px, now.k1, now.k2, now.p1, now.p2;
      if (!ceres_.HasParameterBlock(Lens(c))) continue;
      if (!options_.adjust_lens || lens.is_fixed) {
        ceres_.SetParameterBlockConstant(Lens(c));
        continue;
      }
      PriorResidual<kLensSize> prior;
      prior.expected << 0.0, 0.0, 0.0, was.k1, was.k2, was.p1, was.p2;
      prior.sigma << lens.sigma_focal_share, lens.sigma_center_px, lens.sigma_center_px, lens.sigma_k,
          lens.sigma_k, lens.sigma_p, lens.sigma_p;
      AddPrior(prior, Lens(c));
    }
    for (std::size_t c = 0; c < bundle_.lenses.size(); ++c) {
      if (!ceres_.HasParameterBlock(Readout(c))) continue;
      AddPrior<kReadoutSize>({OneNumber(-bundle_.lenses[c].readout_s), OneNumber(kSigmaReadoutS)},
                             Readout(c));
    }
  }

  // The surveyed place holds the point, the point holds the photos in which it was marked.
  void AddControl() {
    for (std::size_t c = 0; c < bundle_.control.size(); ++c) {
      const BundleControl& tied = bundle_.control[c];
      const std::size_t point = bundle_.tracks.size() + bundle_.soft_tracks.size() + c;
      AddPoint(point);
      PriorResidual<3> prior{tied.surveyed_in_enu, tied.sigma_m};
      if (!tied.has_height) prior.sigma.z() = kUnknownHeightSigmaM;
      AddPrior(prior, Point(point), new ceres::HuberLoss(kControlLossSigmas));
    }
  }

  void AddPlane(std::size_t photos) {
    if (!bundle_.plane || photos == 0) return;
    BundlePlane plane = *bundle_.plane;
    const double points_a_photo =
        std::max(1.0, static_cast<double>(bundle_.tracks.size()) / static_cast<double>(photos));
    plane.sigma_m *= std::sqrt(points_a_photo);
    for (std::size_t t = 0; t < bundle_.tracks.size(); ++t) AddPlaneOf(plane, t);
  }

  void AddPlaneOf(const BundlePlane& plane, std::size_t point) {
    ceres_.AddResidualBlock(Derived<BundlePlane::kRows, kPointSize>(plane), nullptr, Point(point));
  }

  void AddPositionBias() {
    if (!ceres_.HasParameterBlock(PositionBias())) return;
    Eigen::Map<Eigen::Vector3d> bias(PositionBias());
    bias = bundle_.position_bias_m;
    if (bundle_.control.empty()) {
      ceres_.SetParameterBlockConstant(PositionBias());
      return;
    }
    AddPrior<3>({Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(kPositionBiasSigmaM)}, PositionBias());
  }

  void AddClock() {
    if (!ceres_.HasParameterBlock(Clock())) return;
    *Clock() = bundle_.clock_error_s;
    AddPrior<kClockSize>({OneNumber(0.0), OneNumber(bundle_.sigma_clock_s)}, Clock());
  }

  void AddPoint(std::size_t n) {
    Eigen::Map<Eigen::Vector3d>{Point(n)} = points_[n]->point_in_enu;
    for (const Observation& seen : points_[n]->observations) AddObservation(Point(n), seen);
  }

  void AddObservation(double* point, const Observation& seen) {
    const BundlePhoto& photo = bundle_.photos[seen.photo];
    const camera::Intrinsics& lens = bundle_.lenses[photo.lens].recorded;
    if (photo.readout_doubt.IsAny()) {
      ceres_.AddResidualBlock(
          MakeTurningReprojectionCost(photo.cam_from_enu, photo.readout_motion, photo.readout_doubt, lens,
                                      seen.pixel_in_image, seen.sigma_px),
          TieLoss(), Pose(seen.photo), point, Lens(photo.lens), Correction(seen.photo));
      return;
    }
    if (FindsReadoutOf(photo)) {
      ceres_.AddResidualBlock(MakeRollingReprojectionCost(StartAt(seen), *photo.velocity_in_enu_mps,
                                                          seen.pixel_in_image, seen.sigma_px),
                              TieLoss(), Pose(seen.photo), point, Lens(photo.lens), Readout(photo.lens));
      return;
    }
    ceres_.AddResidualBlock(MakeReprojectionCost(StartAt(seen), seen.pixel_in_image, seen.sigma_px),
                            TieLoss(), Pose(seen.photo), point, Lens(photo.lens));
  }

  // Of the whole photo where that is one, of the observation's row where the camera turned.
  std::shared_ptr<const CameraStart> StartAt(const Observation& seen) {
    const BundlePhoto& photo = bundle_.photos[seen.photo];
    const camera::Intrinsics& lens = bundle_.lenses[photo.lens].recorded;
    if (!photo.readout_motion.turns_rad.empty()) {
      return StartOf(camera::PoseAtRow(photo.cam_from_enu, photo.readout_motion, seen.pixel_in_image.y(),
                                       lens.height_px),
                     {}, lens);
    }
    std::shared_ptr<const CameraStart>& start = starts_[seen.photo];
    if (!start) start = StartOf(photo.cam_from_enu, photo.readout_motion, lens);
    return start;
  }

  // One for all observations.
  ceres::LossFunction* TieLoss() {
    if (tie_loss_ == nullptr) tie_loss_ = new ceres::CauchyLoss(kLossSigmas);
    return tie_loss_;
  }

  void AddPriors(std::size_t i) {
    const BundlePhoto& photo = bundle_.photos[i];
    const Eigen::Vector3d turned = geo::TurnAgainst(photo.cam_from_enu, photo.prior_cam_from_enu);
    const Eigen::Vector3d moved =
        photo.cam_from_enu.TargetOriginInSource() - photo.prior_cam_from_enu.TargetOriginInSource();
    ceres_.AddResidualBlock(Derived<3, kPoseSize, 3>(AttitudeResidual{turned, photo.sigma_attitude_rad}),
                            new ceres::HuberLoss(3.0), Pose(i), Bias(photo.line));
    const PositionResidual position{moved, photo.sigma_position_m};
    if (bundle_.sigma_clock_s > 0.0 && photo.has_record && !photo.by_clock_mps.isZero()) {
      const TimedPositionResidual timed{position, photo.by_clock_mps};
      ceres_.AddResidualBlock(Derived<3, kPoseSize, 3, kClockSize>(timed), new ceres::HuberLoss(3.0), Pose(i),
                              PositionBias(), Clock());
      return;
    }
    ceres_.AddResidualBlock(Derived<3, kPoseSize, 3>(position), new ceres::HuberLoss(3.0), Pose(i),
                            PositionBias());
  }

  // The record was right so far; what earlier rounds took off counts too.
  void AddCorrectionPrior(std::size_t i) {
    const BundlePhoto& photo = bundle_.photos[i];
    AddPrior<kCorrectionSize>({-photo.readout_correction, photo.readout_doubt.sigma.cwiseMax(kHeldSigma)},
                              Correction(i));
    if (photo.is_fixed) ceres_.SetParameterBlockConstant(Correction(i));
  }

  void EstimateLensSigma() {
    std::vector<std::pair<const double*, const double*>> blocks;
    for (std::size_t c = 0; c < bundle_.lenses.size(); ++c) {
      if (ceres_.HasParameterBlock(Lens(c)) && !ceres_.IsParameterBlockConstant(Lens(c))) {
        blocks.emplace_back(Lens(c), Lens(c));
      }
    }
    if (blocks.empty()) return;
    ceres::Covariance::Options options;
    options.num_threads = 1;
    ceres::Covariance covariance(options);
    if (!covariance.Compute(blocks, &ceres_)) return;
    for (std::size_t c = 0; c < bundle_.lenses.size(); ++c) {
      Eigen::Matrix<double, kLensSize, kLensSize, Eigen::RowMajor> block;
      if (!ceres_.HasParameterBlock(Lens(c)) ||
          !covariance.GetCovarianceBlock(Lens(c), Lens(c), block.data())) {
        continue;
      }
      bundle_.lenses[c].found_sigma_focal_px =
          std::sqrt(std::max(0.0, block(0, 0))) * bundle_.lenses[c].recorded.focal_x_px;
    }
  }

  void ReadBack(std::vector<Eigen::Vector3d>& line_bias) {
    for (std::size_t i = 0; i < bundle_.photos.size(); ++i) {
      BundlePhoto& photo = bundle_.photos[i];
      photo.cam_from_enu = Applied(photo.cam_from_enu, Pose(i));
      if (FindsReadoutOf(photo))
        photo.readout_motion.shift_in_enu_m += *Readout(photo.lens) * *photo.velocity_in_enu_mps;
      if (!ceres_.HasParameterBlock(Correction(i))) continue;
      const ReadoutCorrection correction = Eigen::Map<const ReadoutCorrection>(Correction(i));
      photo.readout_motion = Corrected(photo.readout_motion, photo.readout_doubt, correction);
      photo.readout_correction += correction;
    }
    for (std::size_t c = 0; c < bundle_.lenses.size(); ++c) {
      bundle_.lenses[c].intrinsics = Applied(bundle_.lenses[c].recorded, Lens(c));
      bundle_.lenses[c].readout_s += *Readout(c);
    }
    for (int l = 0; l < bundle_.lines; ++l) line_bias[l] = Eigen::Map<Eigen::Vector3d>(Bias(l));
    if (!bundle_.control.empty()) bundle_.position_bias_m = Eigen::Map<Eigen::Vector3d>(PositionBias());
    if (ceres_.HasParameterBlock(Clock())) bundle_.clock_error_s = *Clock();
    for (std::size_t n = 0; n < points_.size(); ++n)
      points_[n]->point_in_enu = Eigen::Map<Eigen::Vector3d>(Point(n));
  }

  bool FindsReadoutOf(const BundlePhoto& photo) const {
    return bundle_.lenses[photo.lens].finds_readout && photo.velocity_in_enu_mps && !photo.is_fixed &&
           !photo.readout_doubt.IsAny();
  }

  double* Pose(std::size_t i) { return state_.data() + kPoseSize * i; }
  double* Lens(std::size_t c) { return state_.data() + first_lens_ + kLensSize * c; }
  double* Bias(std::size_t l) { return state_.data() + first_bias_ + kBiasSize * l; }
  double* PositionBias() { return state_.data() + position_bias_; }
  double* Correction(std::size_t i) { return state_.data() + first_correction_ + kCorrectionSize * i; }
  double* Readout(std::size_t c) { return state_.data() + first_readout_ + kReadoutSize * c; }
  double* Clock() { return state_.data() + clock_; }
  double* Point(std::size_t t) { return state_.data() + first_point_ + kPointSize * t; }

  BundleProblem& bundle_;
  const BundleOptions& options_;
  // One buffer for all unknowns: Ceres orders blocks by address, and an order that hangs on where the
  // allocator put things would change the last digits from run to run.
  std::size_t first_lens_, first_bias_, position_bias_, first_point_, first_correction_, first_readout_,
      clock_;
  std::vector<double> state_;
  std::vector<Track*> points_;  // tracks, soft ones and surveyed points, as the state has them
  std::vector<std::shared_ptr<const CameraStart>> starts_;  // by photo, each made when it is first needed
  ceres::LossFunction* tie_loss_ = nullptr;                 // owned by ceres_
  ceres::Problem ceres_;
};

}  // namespace

void SolveRound(const BundleOptions& options, BundleProblem& problem, std::vector<Eigen::Vector3d>& line_bias,
                BundleSummary& summary) {
  Round(problem, options).Solve(line_bias, summary);
}

}  // namespace skyquilt::alignment
