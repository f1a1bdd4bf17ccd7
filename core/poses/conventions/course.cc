#include "core/poses/conventions/course.h"

#include <cmath>

#include "core/geo/lat_lon.h"

namespace skyquilt::poses {
namespace {

struct Leg {
  bool is_usable = false;
  double course_rad = 0.0;
};

double AngleBetween(double a_rad, double b_rad) { return std::abs(geo::WrapRad(a_rad - b_rad)); }

}  // namespace

std::vector<std::optional<double>> CoursesFromPositions(
    const std::vector<Eigen::Vector2d>& positions_in_enu) {
  const std::size_t count = positions_in_enu.size();
  std::vector<std::optional<double>> courses(count);
  if (count < 2) return courses;
  std::vector<Leg> legs(count - 1);
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const Eigen::Vector2d step = positions_in_enu[i + 1] - positions_in_enu[i];
    legs[i] = {step.norm() > 1.0, std::atan2(step.x(), step.y())};
  }
  // How straight the flight runs through the two legs; a lone leg counts as a turn.
  const auto bend = [&](std::size_t a, std::size_t b) {
    if (a >= legs.size() || b >= legs.size() || !legs[a].is_usable || !legs[b].is_usable) return geo::kPi;
    return AngleBetween(legs[a].course_rad, legs[b].course_rad);
  };
  constexpr double kStraightRad = 0.35;
  for (std::size_t i = 0; i < count; ++i) {
    const bool has_before = i > 0 && legs[i - 1].is_usable;
    const bool has_after = i + 1 < count && legs[i].is_usable;
    if (has_before && has_after) {
      const double before_rad = legs[i - 1].course_rad;
      const double turn_rad = geo::WrapRad(legs[i].course_rad - before_rad);
      if (std::abs(turn_rad) < kStraightRad) {
        courses[i] = geo::WrapRad(before_rad + 0.5 * turn_rad);
      } else {
        const bool before_is_straighter = i >= 2 && bend(i - 2, i - 1) <= bend(i, i + 1);
        courses[i] = before_is_straighter ? before_rad : legs[i].course_rad;
      }
    } else if (has_before) {
      courses[i] = legs[i - 1].course_rad;
    } else if (has_after) {
      courses[i] = legs[i].course_rad;
    }
  }
  // Photos taken while hovering share the course of the nearest that moved.
  for (std::size_t i = 1; i < count; ++i) {
    if (!courses[i]) courses[i] = courses[i - 1];
  }
  for (std::size_t i = count - 1; i-- > 0;) {
    if (!courses[i]) courses[i] = courses[i + 1];
  }
  return courses;
}

}  // namespace skyquilt::poses
