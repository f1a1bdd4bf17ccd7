// BringIntoOneFrame: a list that names part of the photos, and the own positions of the others. The two
// seldom count from the same place (base station, datum, geoid): photos of one map that lie in both would
// turn and scale it. Where the photos of a camera that have both tell one common shift, its other photos' own
// positions and heights are moved by it, to where the list has them: who brings a list means it to be the
// better one. Where no common shift shows, they are held for no better than what lies between. Metres, WGS84.
// Pure; any thread. Cost: n log n of the photos.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::poses {

struct OneFrame {
  std::vector<flight::Remark> warnings;  // what was moved or doubted, and by how much
  // From the photos' own positions, where these stay, are more than a few, and no receiver errs so much.
  std::optional<double> contradict_m;
};

// `own`: the photos as they were read; `photos`: the same with the positions of lists and logs on some.
OneFrame BringIntoOneFrame(const std::vector<flight::Photo>& own, std::vector<flight::Photo>& photos);

}  // namespace skyquilt::poses
