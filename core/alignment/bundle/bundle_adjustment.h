// AdjustBundle: the poses, lenses and points that explain all observations best, held by what was recorded.
// Ceres (Levenberg-Marquardt, Schur complement); robust loss on observations and on recorded poses;
// observations too far off are dropped between rounds. Gauge: the recorded positions hold it, so the block
// stays at their mean. A round whose solution Ceres does not call usable (a point behind its camera, say)
// leaves the problem as it was, and the summary says so. One thread by design: sums in a fixed order give the
// same bytes on every machine. Not for concurrent use of one problem.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/alignment/bundle/readout_motion.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/scene/tracks.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

struct BundlePhoto {
  geo::Rigid3 cam_from_enu;        // in: start; out: adjusted
  geo::Rigid3 prior_cam_from_enu;  // as recorded, or as corrected where the images proved the record wrong
  Eigen::Vector3d sigma_position_m = Eigen::Vector3d::Ones();  // apart from the clock's error
  // By how much the recorded place moves with the error of the clock that photos on a log share; zero: it
  // hangs on none.
  Eigen::Vector3d by_clock_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_attitude_rad = Eigen::Vector3d::Constant(0.05);  // apart from the line's common error
  int lens = 0;
  int line = 0;
  double height_above_ground_m = 50.0;
  camera::RowMotion readout_motion;  // as AlignedPhoto has it; in: as recorded; out: adjusted
  ReadoutDoubt readout_doubt;        // what of it is to be adjusted
  ReadoutCorrection readout_correction = ReadoutCorrection::Zero();  // out: by how much it was
  std::optional<Eigen::Vector3d> velocity_in_enu_mps;                // while it was read
  bool is_fixed = false;      // stays where it is; others are placed against it
  bool has_record = true;     // false: the prior is no more than where it was found before
  bool is_by_images = false;  // its place started from what it shows, not from its record
};

// A surveyed point and the photos in which it was marked.
struct BundleControl {
  Track track;
  Eigen::Vector3d surveyed_in_enu = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Constant(0.02);
  bool has_height = true;
  std::size_t report = 0;  // the caller's number
};

// The ground, z = height_m + slope_east * E + slope_north * N, to sigma_m; and the cost term of one point.
struct BundlePlane {
  double height_m = 0.0, slope_east = 0.0, slope_north = 0.0;
  double sigma_m = 5.0;

  // What says something of a point alone has two rows like an observation, the second empty: Ceres eliminates
  // points of one row size by code made for that size, in half the time.
  static constexpr int kRows = 2;
  template <typename T>
  bool operator()(const T* point, T* residual) const {
    residual[0] = (point[2] - height_m - slope_east * point[0] - slope_north * point[1]) / sigma_m;
    residual[1] = T(0.0);
    return true;
  }
};

struct BundleProblem {
  std::vector<BundlePhoto> photos;
  std::vector<BundleLens> lenses;
  int lines = 1;
  std::vector<Track> tracks;
  std::vector<Track> soft_tracks;  // from direct registration: two views, held near the ground
  std::vector<BundleControl> control;
  // What all recorded positions err by alike; found by control, zero without it.
  Eigen::Vector3d position_bias_m = Eigen::Vector3d::Zero();
  // Photos were taken this much later than they were looked up on the track of a log: found where they fly to
  // and fro, zero where nothing shows it.
  double clock_error_s = 0.0;
  double sigma_clock_s = 0.0;  // of it beforehand; 0: no photo hangs on a clock
  double ground_z_in_enu_m = 0.0;
  // What all points together say of the ground: it keeps weakly tied photos from folding it. Weak: a photo's
  // points weigh as much as one height measured to its sigma.
  std::optional<BundlePlane> plane;
};

// Where its record puts a photo, with what was found that all records err by.
Eigen::Vector3d ExpectedCenter(const BundleProblem& problem, const BundlePhoto& photo);

inline constexpr double kReferenceWidthPx = 4000.0;  // of a photo, that errors are told and judged for

struct BundleOptions {
  // At a picture of that width; a round each. 0: what stands out from the others' own spread.
  std::vector<double> cuts_px{20.0, 6.0, 0.0, 0.0};
  int max_iterations = 25;
  bool adjust_lens = true;
  bool estimate_lens_sigma = false;
};

struct BundleSummary {
  double rms_px = 0.0;
  int observations = 0;
  int dropped = 0;
  int iterations = 0;
  std::string solver;       // and, where the last round failed, why
  bool has_failed = false;  // the last round: Ceres found no usable solution
};

BundleSummary AdjustBundle(BundleProblem& problem, const BundleOptions& options);

// One solve from the problem's present state, which becomes the solution where Ceres finds a usable one;
// between such rounds AdjustBundle drops outliers. line_bias: in and out, radians, in cam.
void SolveRound(const BundleOptions& options, BundleProblem& problem, std::vector<Eigen::Vector3d>& line_bias,
                BundleSummary& summary);

// The views of a problem's photos as adjusted.
std::vector<View> ViewsOf(const BundleProblem& problem);

}  // namespace skyquilt::alignment
