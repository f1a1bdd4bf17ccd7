#include "core/alignment/from_records/correct_poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "core/geo/lat_lon.h"

namespace skyquilt::alignment {
namespace {

using Complex = std::complex<double>;

constexpr double kQuarterRad = 0.5 * std::numbers::pi;
constexpr double kNearRad = 0.45;
constexpr int kMinLinks = 8;
constexpr double kShare = 0.8;
constexpr double kBaselineSigmas = 3.0;
constexpr double kMaxStretch = 2.0;  // of the way in the pictures against the recorded one

using flight::Remark;
using flight::RemarkCode;

constexpr double kNearQuarterRad = 0.35;
constexpr double kGrossShiftSigmas = 6.0;
constexpr double kMaxScaleStep = 0.2;
// As courses are told from positions (core/poses/conventions).
constexpr double kBendRad = 0.35;
constexpr double kShortestLegM = 1.0;

Eigen::Quaterniond AboutUp(double angle_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()));
}

int Degrees(int quarter_turns) { return quarter_turns == 3 ? -90 : 90 * quarter_turns; }

// Do photos from one up to the next lie turned against the course, and not against a recorded yaw?
bool IsCourseOfAll(const std::vector<PhotoFindings>& corrected, std::size_t first, std::size_t end) {
  return std::all_of(corrected.begin() + static_cast<std::ptrdiff_t>(first),
                     corrected.begin() + static_cast<std::ptrdiff_t>(end),
                     [](const PhotoFindings& one) { return one.yaw_is_course; });
}

// Where the course was one of two that the photo stands between, or none. `photos`: of one camera.
bool BendsAt(const std::vector<poses::PosedPhoto>& recorded, const std::vector<std::size_t>& photos,
             std::size_t k) {
  if (k == 0 || k + 1 >= photos.size()) return false;
  const auto place = [&](std::size_t at) {
    return Eigen::Vector2d(recorded[photos[at]].cam_from_enu.TargetOriginInSource().head<2>());
  };
  const Eigen::Vector2d before = place(k) - place(k - 1), after = place(k + 1) - place(k);
  if (std::min(before.norm(), after.norm()) < kShortestLegM) return true;
  return std::acos(std::clamp(before.normalized().dot(after.normalized()), -1.0, 1.0)) > kBendRad;
}

// How a pose moves a photo over level ground against its record, about its middle.
GroundSimilarity GroundMotion(const poses::PosedPhoto& posed, Complex recorded_middle,
                              const geo::Rigid3& cam_from_enu) {
  const double ground_z_m = posed.cam_from_enu.TargetOriginInSource().z() - posed.height_above_ground_m;
  const Eigen::Quaterniond enu_from_cam = cam_from_enu.rotation.conjugate();
  const Eigen::Vector2d middle = AxisOnGround(enu_from_cam, cam_from_enu.TargetOriginInSource(), ground_z_m);
  const Eigen::Vector3d right_now = enu_from_cam * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d right_before = posed.cam_from_enu.rotation.conjugate() * Eigen::Vector3d::UnitX();
  const double turn =
      std::atan2(right_now.y(), right_now.x()) - std::atan2(right_before.y(), right_before.x());
  return {std::polar(1.0, turn), Complex(middle.x(), middle.y()) - recorded_middle};
}

}  // namespace

double CommonQuarterTurn(const std::vector<PhotoGround>& recorded, const std::vector<PhotoPair>& pairs) {
  std::array<int, 4> votes{};
  int asked = 0;
  for (const PhotoPair& pair : pairs) {
    const Complex first = recorded[pair.first].middle;
    const Complex second = recorded[pair.second].middle;
    const Complex way = second - first;
    if (std::abs(way) < kBaselineSigmas * recorded[pair.first].sigma_m) continue;
    // One place of the ground, seen from both middles: were all photos turned right, the difference were the
    // way.
    const Complex between = 0.5 * (first + second);
    const Complex shown = (between - first) - (pair.second_from_first * between - second);
    if (std::abs(shown) < std::abs(way) / kMaxStretch || std::abs(shown) > kMaxStretch * std::abs(way))
      continue;
    ++asked;
    const double turn = std::arg(way / shown);
    const double quarters = std::round(turn / kQuarterRad);
    if (std::abs(turn - quarters * kQuarterRad) > kNearRad) continue;
    ++votes[(static_cast<int>(quarters) + 4) % 4];
  }
  for (int quarters = 1; quarters < 4; ++quarters) {
    const int agree = votes[quarters];
    if (agree >= kMinLinks && agree >= kShare * asked) {
      return quarters == 3 ? -kQuarterRad : quarters * kQuarterRad;
    }
  }
  return 0.0;
}

PhotoFindings CorrectPose(const poses::PosedPhoto& posed, const PhotoGround& ground) {
  const GroundSimilarity& correction = ground.correction;
  PhotoFindings corrected;
  corrected.start_cam_from_enu = corrected.prior_cam_from_enu = posed.cam_from_enu;
  corrected.yaw_is_course = posed.attitude_origin == poses::AttitudeOrigin::kCourse;
  if (ground.component < 0 && ground.component != kInheritedComponent) return corrected;
  const double turn = std::arg(correction.turn_and_scale);
  const double quarters = std::round(turn / (0.5 * std::numbers::pi));
  double rest = turn - quarters * 0.5 * std::numbers::pi;
  const double believable = std::max(0.35, 4.0 * ground.sigma_turn_rad);
  Eigen::Quaterniond rotation = posed.cam_from_enu.rotation;  // cam_from_enu
  Eigen::Vector3d center = posed.cam_from_enu.TargetOriginInSource();
  if (std::abs(turn) > believable) {
    if (std::abs(rest) < kNearQuarterRad) {
      // The picture was stored turned, so it turns about its own axis and the tilt stays right.
      corrected.quarter_turns = (static_cast<int>(quarters) + 4) % 4;
      rotation = AboutUp(quarters * 0.5 * std::numbers::pi) * rotation;  // about z of cam
      corrected.notes.push_back(
          {corrected.yaw_is_course ? RemarkCode::kFoundTurnedAgainstCourse : RemarkCode::kFoundTurned,
           {{"turn_deg", Degrees(corrected.quarter_turns)}}});
    } else {
      rotation = rotation * AboutUp(-turn);
      rest = 0.0;
      corrected.yaw_was_wrong = true;
      corrected.notes.push_back(
          {corrected.yaw_is_course ? RemarkCode::kCourseYawCorrected : RemarkCode::kYawCorrected,
           {{"off_deg", std::abs(geo::RadToDeg(turn))}}});
    }
  }
  const double shift_m = std::abs(correction.shift);
  const Eigen::Vector3d shift(correction.shift.real(), correction.shift.imag(), 0.0);
  if (shift_m > kGrossShiftSigmas * ground.sigma_m) {
    corrected.position_was_wrong = true;
    center += shift;
    corrected.notes.push_back({RemarkCode::kPositionCorrected, {{"off_m", shift_m}}});
  }
  corrected.prior_cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(rotation, center);

  // The rest is ordinary error: shared between tilt and position as their sigmas say.
  const double height = std::max(1.0, posed.height_above_ground_m);
  const double by_tilt_m = height * std::sqrt(0.5 * (posed.covariance(0, 0) + posed.covariance(1, 1)));
  const double by_position_m = std::sqrt(0.5 * (posed.covariance(3, 3) + posed.covariance(4, 4)));
  const double tilt_share =
      by_tilt_m * by_tilt_m / std::max(1e-9, by_tilt_m * by_tilt_m + by_position_m * by_position_m);
  Eigen::Quaterniond enu_from_cam = AboutUp(rest) * rotation.conjugate();
  const double scale =
      std::clamp(std::abs(correction.turn_and_scale), 1.0 - kMaxScaleStep, 1.0 + kMaxScaleStep);
  const double ground_z_m = center.z() - height;
  center.z() = ground_z_m + height * scale;
  // Turning and climbing move what a leaning camera looks at: what is still missing is asked for again.
  const Eigen::Vector2d wanted(ground.middle.real() + correction.shift.real(),
                               ground.middle.imag() + correction.shift.imag());
  for (int step = 0; step < 3; ++step) {
    const Eigen::Vector2d missing = wanted - AxisOnGround(enu_from_cam, center, ground_z_m);
    const Eigen::Vector2d by_tilt = tilt_share * missing / (height * scale);
    enu_from_cam = (geo::RotationFromVector(Eigen::Vector3d(by_tilt.y(), -by_tilt.x(), 0.0)) * enu_from_cam)
                       .normalized();
    center.head<2>() += (1.0 - tilt_share) * missing;
  }
  corrected.start_cam_from_enu =
      geo::Rigid3::FromRotationAndTargetOrigin(enu_from_cam.conjugate().normalized(), center);
  return corrected;
}

PhotoFindings CorrectToPose(const poses::PosedPhoto& posed, PhotoGround ground,
                            const geo::Rigid3& cam_from_enu) {
  ground.correction = GroundMotion(posed, ground.middle, cam_from_enu);
  ground.component = 0;
  PhotoFindings corrected = CorrectPose(posed, ground);
  corrected.start_cam_from_enu = cam_from_enu;
  return corrected;
}

void ForgiveTurnsAtBends(const std::vector<poses::PosedPhoto>& recorded,
                         std::vector<PhotoFindings>& corrected) {
  std::map<std::string, std::vector<std::size_t>> photos_of_camera;
  for (std::size_t i = 0; i < corrected.size(); ++i)
    photos_of_camera[recorded[i].photo.camera_key].push_back(i);
  for (const auto& of_camera : photos_of_camera) {
    const std::vector<std::size_t>& photos = of_camera.second;  // Clang 14's lambdas take no bindings
    std::array<std::size_t, 4> lie_so{};
    for (const std::size_t i : photos) ++lie_so[corrected[i].quarter_turns];
    for (std::size_t k = 0; k < photos.size(); ++k) {
      PhotoFindings& one = corrected[photos[k]];
      const int quarters = one.quarter_turns;
      if (!one.yaw_is_course || quarters == 0 || !BendsAt(recorded, photos, k)) continue;
      const auto says_the_same = [&](std::size_t at) {
        return corrected[photos[at]].quarter_turns == quarters && !BendsAt(recorded, photos, at);
      };
      if (2 * lie_so[quarters] > photos.size() || says_the_same(k - 1) || says_the_same(k + 1)) continue;
      one.quarter_turns = 0;
      std::erase_if(one.notes,
                    [](const Remark& note) { return note.code == RemarkCode::kFoundTurnedAgainstCourse; });
    }
  }
}

std::vector<Remark> DescribeCorrections(const std::vector<PhotoFindings>& corrected,
                                        const std::vector<std::string>& names,
                                        const std::vector<int>& lines) {
  std::vector<Remark> remarks;
  const std::size_t count = corrected.size();
  const bool is_mount = count > 1 && corrected.front().quarter_turns != 0 &&
                        std::all_of(corrected.begin(), corrected.end(), [&](const PhotoFindings& one) {
                          return one.quarter_turns == corrected.front().quarter_turns;
                        });
  if (is_mount) {
    remarks.push_back({IsCourseOfAll(corrected, 0, count) ? RemarkCode::kMountTurnedAgainstCourse
                                                          : RemarkCode::kMountTurned,
                       {{"turn_deg", Degrees(corrected.front().quarter_turns)}}});
  }
  for (std::size_t i = 0; i < count;) {
    std::size_t end = i + 1;
    const int quarters = corrected[i].quarter_turns;
    while (quarters != 0 && !is_mount && end < count && corrected[end].quarter_turns == quarters &&
           lines[end] == lines[i] && !corrected[end].position_was_wrong) {
      ++end;
    }
    if (end - i > 1) {
      remarks.push_back({IsCourseOfAll(corrected, i, end) ? RemarkCode::kPhotosStoredTurnedAgainstCourse
                                                          : RemarkCode::kPhotosStoredTurned,
                         {{"first", names[i]}, {"last", names[end - 1]}, {"turn_deg", Degrees(quarters)}}});
    } else if (!(is_mount && !corrected[i].position_was_wrong)) {
      for (const Remark& note : corrected[i].notes)
        remarks.push_back({RemarkCode::kOfPhoto, {{"photo", names[i]}, {"said", note}}});
    }
    i = end;
  }
  return remarks;
}

}  // namespace skyquilt::alignment
