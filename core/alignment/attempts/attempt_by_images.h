// The second attempt of the alignment: where recorded poses fail their test, photos are placed by what they
// show alone (RegisterPhotos), and the records count only where they agree with that. What comes back is an
// attempt as the first one is before its adjustment, with a posed flight, verified pairs and lenses: the
// alignment goes on from it. The same for any number of threads.
#pragma once

#include <optional>
#include <vector>

#include "core/alignment/attempts/attempt_evidence.h"
#include "core/alignment/scene/ground_control.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// How well a place is known that no record tells, before the images are asked again: a share of the height.
inline constexpr double kUnknownShare = 0.5;

// A pose found from images alone, with such uncertainty that the adjustment may move it.
void HoldLoosely(const geo::Rigid3& cam_from_enu, const Eigen::Vector3d& sigma_m, poses::PosedPhoto& photo);

// A flight with the photos that it could not place as photos of it: in the order of capture, with poses that
// stand for none, and of the records only the horizontal position, if there is one. Fills `posed` and
// `records`.
ExtractedFlight WithUnplaced(const poses::PosedFlight& recorded);

// The outcome of an attempt whose result is not the map's.
flight::Remark NotTaken(flight::Remark why);

// The attempt from where the images place the photos, as if the records had said so. Nothing where it ties no
// more photos together than `tied_by_records`, or where that cannot be told apart from an equal
// (`takes_equal`: then it may tie as many). Fills by_records.report.by_images.
std::optional<Attempt> PlaceByImages(const ExtractedFlight& extracted, std::size_t tied_by_records,
                                     bool takes_equal, const std::vector<ControlPoint>& control, int threads,
                                     Attempt& by_records, Progress& progress);

// Photos that nothing placed go back to those left out, and those that were placed leave that list. Errors:
// kUnprocessable when nothing is left.
Result<void> SettleUnplaced(const ExtractedFlight& extracted, AlignedFlight& flight, AlignReport& report);

// What the user must know of it; empty where the records held.
std::vector<flight::Remark> RemarksOn(const ByImagesReport& report);

}  // namespace skyquilt::alignment
