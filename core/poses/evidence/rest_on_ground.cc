#include "core/poses/evidence/rest_on_ground.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::poses {

bool IsAloft(const std::vector<HeightFix>& heights, const StillInterval& interval) {
  constexpr double kGroundM = 2.5;   // the barometer's drift over a flight and its noise
  constexpr double kAroundS = 60.0;  // take-off and landing may lie at different heights
  double ground = 1e9;
  for (const HeightFix& h : heights) {
    if (h.t_s > interval.begin_s - kAroundS && h.t_s < interval.end_s + kAroundS) {
      ground = std::min(ground, h.z_in_enu_m);
    }
  }
  return std::any_of(heights.begin(), heights.end(), [&](const HeightFix& h) {
    return h.t_s >= interval.begin_s && h.t_s <= interval.end_s && h.z_in_enu_m > ground + kGroundM;
  });
}

StillInterval AtOneHeight(const std::vector<HeightFix>& heights, StillInterval interval,
                          bool flight_follows) {
  constexpr double kReferenceS = 1.5;
  constexpr double kSameM = 0.5;  // well beyond the barometer's noise
  constexpr double kAwayS = 0.7;  // from the last sign of motion
  double sum = 0.0;
  int count = 0;
  const auto inside = [&](const HeightFix& h) {
    return h.t_s >= interval.begin_s && h.t_s <= interval.end_s;
  };
  for (const HeightFix& h : heights) {
    const double from_edge = flight_follows ? h.t_s - interval.begin_s : interval.end_s - h.t_s;
    if (!inside(h) || from_edge > kReferenceS) continue;
    sum += h.z_in_enu_m;
    ++count;
  }
  StillInterval kept = interval;
  // Settling onto the ground may take seconds that feel like rest.
  if (!flight_follows) kept.begin_s = 0.5 * (interval.begin_s + interval.end_s);
  for (const HeightFix& h : heights) {
    if (count == 0 || !inside(h) || std::abs(h.z_in_enu_m - sum / count) < kSameM) continue;
    if (flight_follows) {
      kept.end_s = std::min(kept.end_s, h.t_s);
    } else {
      kept.begin_s = std::max(kept.begin_s, h.t_s);
    }
  }
  (flight_follows ? kept.end_s : kept.begin_s) += flight_follows ? -kAwayS : kAwayS;
  return kept;
}

}  // namespace skyquilt::poses
