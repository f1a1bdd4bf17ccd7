// Assumption: what poses are estimated with where nothing is recorded. The map rests on it only as far as
// poses alone place the photos; photos that are aligned have the value found. Values and words for the
// report; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace skyquilt::poses {

struct Assumption {
  std::string missing;                          // the sentence that says what no record tells
  std::string assumed;                          // the sentences that say what is taken instead
  std::optional<double> height_above_ground_m;  // that is assumed; nothing: the assumption is of angles

  // Where poses alone place the photos.
  std::string InWords() const { return missing + " " + assumed; }
};

// Where photos are aligned: `found_height_m` above the ground in the median, `by_pose` of the photos still by
// their poses alone.
std::vector<std::string> AssumptionsAfterAlignment(const std::vector<Assumption>& assumptions,
                                                   double found_height_m, int by_pose);

}  // namespace skyquilt::poses
