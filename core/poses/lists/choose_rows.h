// ChooseRows: of several rows that say where one photo was taken, in one list or in several, the one that
// holds: a corrected one (RTK, PPK) before one that is not; of the others those of the list that states the
// better accuracy, then that lies nearer to the photos' own positions, over all photos that the same lists
// name, so that neighbours do not hang on different lists by chance. Names of files decide nothing. The rows
// that do not hold lose their positions, and their angles where the one that holds has some; lists that
// differ by more than their accuracies are named in the flight's warnings, and its uses count only what
// holds. To be called once, when the rows have their places. Cost: n log n of the rows. Any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/flight.h"
#include "core/geo/lat_lon.h"
#include "core/poses/lists/named_photos.h"

namespace skyquilt::poses {

// What rows of the files of one exposure, or of its bands, are apart by rounding and by their lenses.
inline constexpr double kOneExposureM = 1.0;

// `own`: by photo, where it says itself that it was taken.
void ChooseRows(const NamedPhotos& named, const std::vector<std::optional<geo::LatLon>>& own,
                flight::Flight& flight);

}  // namespace skyquilt::poses
