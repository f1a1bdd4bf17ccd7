#include "core/alignment/from_records/bundle_setup.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/alignment/bundle/readout_motion.h"
#include "core/alignment/matching/verified_pair.h"
#include "core/base/median.h"
#include "core/geo/height_trend.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::alignment {

namespace {

constexpr double kMinSigmaM = 0.01;
constexpr double kMinSigmaRad = 0.003;
constexpr int kFewPhotos = 30;
constexpr double kMaxAttitudeGrowth = 8.0;
constexpr std::size_t kFewestReweighed = 6;  // photos
constexpr double kMinFalseClaimM = 0.08;     // less is a lens or a shutter that is modelled a little wrong
constexpr double kSharedClockS = 0.05;       // clocks that are surer move no photo by more than its own error
// Of the way that the clock is unsure by: so far nobody flies straight and at one speed.
constexpr double kClockBend = 0.1;

double SigmaHorizontalM(const poses::PosedPhoto& photo) {
  return std::max(kMinSigmaM, std::sqrt(0.5 * (photo.covariance(3, 3) + photo.covariance(4, 4))));
}

double SigmaTiltRad(const poses::PosedPhoto& photo) {
  return std::max(kMinSigmaRad, std::sqrt(0.5 * (photo.covariance(0, 0) + photo.covariance(1, 1))));
}

// Of one coordinate's variance, what is not the clock's that all photos share.
double SigmaApartM(double variance_m2, double by_clock_m) {
  return std::max({kMinSigmaM, kClockBend * std::abs(by_clock_m),
                   std::sqrt(std::max(0.0, variance_m2 - by_clock_m * by_clock_m))});
}

BundleLens MakeLens(const flight::Photo& photo, int photos) {
  BundleLens lens;
  lens.recorded = lens.intrinsics = photo.intrinsics;
  const double width = photo.intrinsics.width_px;
  const bool few = photos < kFewPhotos;
  lens.sigma_center_px = (few ? 0.002 : 0.004) * width;
  lens.sigma_k = few ? 0.02 : 0.05;
  lens.sigma_p = few ? 0.0003 : 0.0006;
  switch (photo.focal_source) {
    case flight::FocalSource::kDewarpData:
      lens.sigma_focal_share = 0.003;
      lens.sigma_center_px = 0.001 * width;
      lens.sigma_k = 0.005;
      lens.sigma_p = 0.0003;
      break;
    case flight::FocalSource::kCalibrated:  // focal length and centre: they tell nothing of the distortion
      lens.sigma_focal_share = 0.003;
      lens.sigma_center_px = 0.001 * width;
      break;
    case flight::FocalSource::k35mmEquivalent:
      lens.sigma_focal_share = 0.02;  // whole millimetres of an equivalent
      break;
    case flight::FocalSource::kDoubtful:
      lens.sigma_focal_share = 0.3;  // a zoom of up to two, counted or not
      break;
    case flight::FocalSource::kAssumed:
      lens.sigma_focal_share = 0.1;
      break;
    default:
      lens.sigma_focal_share = 0.01;
  }
  return lens;
}

// Angles of an aircraft without gimbal are worth far less than those of one with; the line's common error is
// not counted.
void ReweighAttitudes(BundleProblem& problem) {
  const PhotoSet tied = ObservingPhotos(problem.photos.size(), problem.tracks);
  std::size_t records = 0;
  std::map<int, std::vector<Eigen::Vector3d>> turns_of_line;
  for (std::size_t i = 0; i < problem.photos.size(); ++i) {
    const BundlePhoto& photo = problem.photos[i];
    if (!tied.Has(i) || photo.is_fixed) continue;
    turns_of_line[photo.line].push_back(geo::TurnAgainst(photo.cam_from_enu, photo.prior_cam_from_enu));
    records += photo.has_record ? 1 : 0;
  }
  if (records < kFewestReweighed) return;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> apart;
    for (const auto& [line, turns] : turns_of_line) {
      std::vector<double> values;
      for (const Eigen::Vector3d& turn : turns) values.push_back(turn[axis]);
      const double middle = turns.size() > 2 ? Median(values) : 0.0;
      for (const double value : values) apart.push_back(std::abs(value - middle));
    }
    const double sigma = 1.8 * Median(apart);
    for (BundlePhoto& photo : problem.photos) {
      double& own = photo.sigma_attitude_rad[axis];
      own = std::clamp(sigma, own, kMaxAttitudeGrowth * own);
    }
  }
}

}  // namespace

std::vector<int> FindLines(const std::vector<Eigen::Vector2d>& east_north) {
  constexpr double kCosineOfTurn = 0.82;  // 35 degrees
  constexpr double kGap = 4.0;
  std::vector<int> lines(east_north.size(), 0);
  if (east_north.size() < 3) return lines;
  std::vector<double> spacings;
  for (std::size_t i = 1; i < east_north.size(); ++i) {
    spacings.push_back((east_north[i] - east_north[i - 1]).norm());
  }
  const double usual = Median(spacings);
  int line = 0;
  std::size_t start = 0;
  for (std::size_t i = 1; i < east_north.size(); ++i) {
    const double spacing = spacings[i - 1];
    bool ends = spacing > kGap * usual;
    if (!ends && i - start >= 2 && spacing > 0.2 * usual) {
      // Against the line's course so far, not only its last step: noise in positions must not end it.
      const std::size_t from = i - start > 4 ? i - 4 : start;
      const Eigen::Vector2d course = east_north[i - 1] - east_north[from];
      const double length = course.norm();
      ends =
          length > 1e-6 && course.dot(east_north[i] - east_north[i - 1]) < kCosineOfTurn * length * spacing;
    }
    if (ends) {
      ++line;
      start = i;
    }
    lines[i] = line;
  }
  return lines;
}

MatchedFlight MakeMatchedFlight(const poses::PosedFlight& posed) {
  MatchedFlight input;
  input.features.assign(posed.photos.size(), nullptr);
  for (const poses::PosedPhoto& photo : posed.photos) {
    const double height = std::max(1.0, photo.height_above_ground_m);
    input.views.push_back({photo.photo.intrinsics, photo.cam_from_enu, height, {}});
    if (photo.photo.turning && !photo.photo.is_resaved_by_viewer)
      input.views.back().readout_motion = ReadoutMotion(photo, 0);
    input.ground_sigma_m.push_back(std::hypot(SigmaHorizontalM(photo), height * SigmaTiltRad(photo)));
    input.sigma_turn_rad.push_back(std::max(kMinSigmaRad, std::sqrt(photo.covariance(2, 2))));
  }
  return input;
}

std::vector<PhotoGround> MakeGrounds(const poses::PosedFlight& posed, const MatchedFlight& input) {
  constexpr double kUnlikeWidth = 2.0;  // less is the wander of heights
  std::vector<PhotoGround> grounds;
  const Relief flat(posed.ground_z_in_enu_m);
  const double median_width_m = MedianWidthM(input.views);
  for (std::size_t i = 0; i < posed.photos.size(); ++i) {
    const View& view = input.views[i];
    Eigen::Vector3d middle = view.CenterInEnu();
    const Eigen::Vector2d axis(view.intrinsics.center_x_px, view.intrinsics.center_y_px);
    if (!MeetGround(view, flat, axis, &middle)) middle = view.CenterInEnu();
    const double width = view.WidthM() / median_width_m;
    grounds.push_back({{middle.x(), middle.y()},
                       input.ground_sigma_m[i],
                       input.sigma_turn_rad[i],
                       width > kUnlikeWidth ? width : 1.0});
  }
  return grounds;
}

double MedianWidthM(const std::vector<View>& views) {
  return views.empty() ? 1.0 : MedianOf(views, &View::WidthM);
}

std::vector<PhotoPair> OnlyWithinComponents(const std::vector<PhotoPair>& pairs,
                                            const std::vector<PhotoPair>& verified, std::size_t photos) {
  const std::vector<int> component = FindConnectedComponents(photos, verified).of_photo;
  std::map<std::pair<int, int>, double> kept;  // overlap
  for (const PhotoPair& pair : verified) {
    kept.emplace(std::pair(pair.first, pair.second), 0.0);
  }
  for (const PhotoPair& pair : pairs) {
    if (component[pair.first] >= 0 && component[pair.first] == component[pair.second])
      kept[{pair.first, pair.second}] = pair.overlap;
  }
  std::vector<PhotoPair> sorted;
  for (const auto& [photos_of_pair, overlap] : kept) {
    sorted.push_back({.first = photos_of_pair.first, .second = photos_of_pair.second, .overlap = overlap});
  }
  return sorted;
}

BundlePhoto MakeBundlePhoto(const poses::PosedPhoto& posed, const PhotoFindings& corrected, int lens,
                            int line) {
  BundlePhoto bundled;
  bundled.cam_from_enu = corrected.start_cam_from_enu;
  bundled.prior_cam_from_enu = corrected.prior_cam_from_enu;
  bundled.lens = lens;
  bundled.line = line;
  bundled.height_above_ground_m = std::max(1.0, posed.height_above_ground_m);
  bundled.velocity_in_enu_mps = posed.velocity_in_enu_mps;
  bundled.readout_motion = ReadoutMotion(posed, corrected.quarter_turns);
  if (!posed.readout_motion && !bundled.readout_motion.turns_rad.empty())
    bundled.readout_doubt = DoubtOfReadout(posed, corrected.quarter_turns);
  if (posed.clock_sigma_s > kSharedClockS && posed.velocity_in_enu_mps && !corrected.position_was_wrong)
    bundled.by_clock_mps = *posed.velocity_in_enu_mps;
  const Eigen::Vector3d by_clock_m = posed.clock_sigma_s * bundled.by_clock_mps;
  const double sigma_h = SigmaApartM(0.5 * (posed.covariance(3, 3) + posed.covariance(4, 4)),
                                     std::sqrt(0.5) * by_clock_m.head<2>().norm());
  const double sigma_v = SigmaApartM(posed.covariance(5, 5), by_clock_m.z());
  bundled.sigma_position_m = {sigma_h, sigma_h, sigma_v};
  if (corrected.position_was_wrong) bundled.sigma_position_m.head<2>().setConstant(5.0 * sigma_h + 5.0);
  // In cam: x and y are tilts, z is the turn about the optical axis (yaw for a camera that looks down).
  const double tilt = SigmaTiltRad(posed);
  const double yaw = std::max(kMinSigmaRad, std::sqrt(posed.covariance(2, 2)));
  bundled.sigma_attitude_rad = {tilt, tilt, std::max(yaw, tilt)};
  if (corrected.yaw_was_wrong) bundled.sigma_attitude_rad.z() = 0.3;
  return bundled;
}

BundleProblem MakeBundle(const poses::PosedFlight& posed, const std::vector<PhotoFindings>& corrected,
                         const std::vector<int>& lines) {
  BundleProblem problem;
  problem.ground_z_in_enu_m = posed.ground_z_in_enu_m;
  std::map<std::string, int> photos_of_key, lens_of_key;
  for (const poses::PosedPhoto& photo : posed.photos) ++photos_of_key[photo.photo.camera_key];
  for (std::size_t i = 0; i < posed.photos.size(); ++i) {
    const poses::PosedPhoto& photo = posed.photos[i];
    const std::string& key = photo.photo.camera_key;
    const auto [lens, is_new] = lens_of_key.emplace(key, static_cast<int>(problem.lenses.size()));
    if (is_new) problem.lenses.push_back(MakeLens(photo.photo, photos_of_key[key]));
    problem.photos.push_back(MakeBundlePhoto(photo, corrected[i], lens->second, lines[i]));
    problem.sigma_clock_s = std::max(problem.sigma_clock_s, photo.clock_sigma_s);
  }
  problem.lines = lines.empty() ? 1 : *std::max_element(lines.begin(), lines.end()) + 1;
  return problem;
}

bool ReweighPositions(BundleProblem& problem) {
  const PhotoSet tied = ObservingPhotos(problem.photos.size(), problem.tracks);
  std::vector<double> horizontal, vertical, horizontal_sigmas, vertical_sigmas;
  for (std::size_t i = 0; i < problem.photos.size(); ++i) {
    const BundlePhoto& photo = problem.photos[i];
    // Where one stays is no record that could turn out good.
    if (!tied.Has(i) || !photo.has_record || photo.is_fixed) continue;
    const Eigen::Vector3d moved_m =
        (photo.cam_from_enu.TargetOriginInSource() - ExpectedCenter(problem, photo)).cwiseAbs();
    const Eigen::Vector3d sigmas = moved_m.cwiseQuotient(photo.sigma_position_m);
    horizontal.insert(horizontal.end(), {moved_m.x(), moved_m.y()});
    horizontal_sigmas.insert(horizontal_sigmas.end(), {sigmas.x(), sigmas.y()});
    vertical.push_back(moved_m.z());
    vertical_sigmas.push_back(sigmas.z());
  }
  if (vertical.size() < kFewestReweighed) return false;
  constexpr double kSigmaOfFitted = 1.8;  // kSigmaOfMedian, and a little more, for it was fitted
  const double sigma_h = kSigmaOfFitted * Median(horizontal);
  const double sigma_v = kSigmaOfFitted * Median(vertical);
  // By what each claims of itself: how far poor ones lie off says nothing of good ones among them.
  const bool is_false_h = kSigmaOfFitted * Median(horizontal_sigmas) > poses::kFalseClaim;
  const bool is_false_v = kSigmaOfFitted * Median(vertical_sigmas) > poses::kFalseClaim;
  bool has_grown = false;
  for (BundlePhoto& photo : problem.photos) {
    if (!photo.has_record) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const double seen = axis < 2 ? sigma_h : sigma_v;
      double& own = photo.sigma_position_m[axis];
      // Positions that claim far more than they hold have bent the pictures to themselves: how far they err
      // shows when they are believed no more than any receiver's.
      const bool is_false =
          (axis < 2 ? is_false_h : is_false_v) && seen > poses::kFalseClaim * own && seen > kMinFalseClaimM;
      has_grown = has_grown || is_false;
      own = is_false ? std::max(seen, flight::kPlainSigmaM) : std::clamp(seen, std::min(0.1, own), own);
    }
  }
  return has_grown;
}

bool ReweighPriors(BundleProblem& problem) {
  ReweighAttitudes(problem);
  return ReweighPositions(problem);
}

std::optional<BundlePlane> FitPlane(const BundleProblem& problem) {
  constexpr std::size_t kFewPoints = 60;
  constexpr double kMinSigmaShare = 0.04;  // of the flying height
  constexpr double kMadsOfSigma = 1.5;
  const std::vector<Eigen::Vector3d> points = PointsWithHeights(problem.tracks);
  if (points.size() < kFewPoints) return std::nullopt;
  const double min_sigma_m = kMinSigmaShare * MedianOf(problem.photos, &BundlePhoto::height_above_ground_m);
  const geo::HeightTrend plane = geo::FitShape(points, geo::HeightTrend::Shape::kPlane, 0.1 * min_sigma_m);
  return BundlePlane{plane.At(Eigen::Vector2d::Zero()), plane.slope.x(), plane.slope.y(),
                     std::max(min_sigma_m, kMadsOfSigma * plane.error_m)};
}

}  // namespace skyquilt::alignment
