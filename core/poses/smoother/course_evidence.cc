#include "core/poses/smoother/course_evidence.h"

#include <algorithm>
#include <cmath>

#include "core/base/median.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::poses {
namespace {

constexpr double kStraightRadps = 0.087;  // 5 deg/s
constexpr double kSigmasInMedian = 1.4826;
constexpr double kBestSigmaRad = 0.035;  // no nose is known to keep to its course better: 2 deg
constexpr double kWorstSigmaRad = 0.26;  // beyond 15 deg it does not keep to it
constexpr std::size_t kFewest = 10;

double Heading(const Eigen::Vector3d& direction) { return std::atan2(direction.x(), direction.y()); }

}  // namespace

std::optional<CourseEvidence> JudgeCourse(const std::vector<KnotState>& knots,
                                          const std::vector<double>& times_s, double min_speed_mps) {
  std::vector<double> nose, course;
  for (const KnotState& knot : knots) {
    nose.push_back(Heading(knot.enu_from_body * Eigen::Vector3d::UnitX()));
    course.push_back(Heading(knot.velocity_in_enu_mps));
  }
  CourseEvidence evidence;
  evidence.runs_straight.assign(knots.size(), false);
  std::vector<double> apart;
  for (std::size_t k = 1; k + 1 < knots.size(); ++k) {
    const double most = kStraightRadps * (times_s[k + 1] - times_s[k - 1]);
    evidence.runs_straight[k] = knots[k].velocity_in_enu_mps.head<2>().norm() > min_speed_mps &&
                                std::abs(geo::WrapRad(nose[k + 1] - nose[k - 1])) < most &&
                                std::abs(geo::WrapRad(course[k + 1] - course[k - 1])) < most;
    if (evidence.runs_straight[k]) apart.push_back(std::abs(geo::WrapRad(nose[k] - course[k])));
  }
  if (apart.size() < kFewest) return std::nullopt;
  evidence.sigma_rad = std::max(kBestSigmaRad, kSigmasInMedian * Median(std::move(apart)));
  if (evidence.sigma_rad > kWorstSigmaRad) return std::nullopt;
  return evidence;
}

}  // namespace skyquilt::poses
