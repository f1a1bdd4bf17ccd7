#include "core/poses/evidence/assumption.h"

#include <fmt/format.h>

namespace skyquilt::poses {

std::vector<std::string> AssumptionsAfterAlignment(const std::vector<Assumption>& assumptions,
                                                   double found_height_m, int by_pose) {
  std::vector<std::string> words;
  for (const Assumption& one : assumptions) {
    std::string now = one.missing;
    if (one.height_above_ground_m) {
      now += fmt::format(
          " {:.0f} m above the ground was assumed to begin with; by what the photos show it was {:.0f} m.",
          *one.height_above_ground_m, found_height_m);
    } else {
      now += " Their angles were found from what they show.";
    }
    if (by_pose > 0) {
      now += fmt::format(" For the {} photos that are placed by their poses alone the assumption stands: {}",
                         by_pose, one.assumed);
    }
    words.push_back(std::move(now));
  }
  return words;
}

}  // namespace skyquilt::poses
