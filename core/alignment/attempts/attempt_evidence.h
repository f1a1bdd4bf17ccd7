// AttemptEvidence: how well an alignment stands, measured alike whichever attempt it came from (recorded
// poses, or what the photos show alone), and the choice between the two by it: photos tied together in one
// connected component first, then by how much they disagree, then how many records they contradict. Pure; any
// thread.
#pragma once

#include <cstddef>
#include <optional>

#include "core/alignment/attempts/attempt.h"
#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/photo_set.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::alignment {

// A record further than this from where the images put its photo contradicts them.
inline constexpr double kContradictedSigmas = poses::kFalseClaim;

struct AttemptEvidence {
  std::size_t readable = 0;      // photos that show enough to be tied
  std::size_t unplaced = 0;      // of those: no record says where, or how high, and nothing tied them
  std::size_t tied = 0;          // in the largest connected component, by enough points
  double residual_rms_px = 0.0;  // at a picture 4000 pixels wide; 0 before any adjustment
  // Kept and dropped by that adjustment. None of either: all were refused before it.
  int observations = 0, dropped = 0;
  bool is_adjusted = false;
  bool has_fixed = false;                                  // photos of a map that stays
  std::size_t positions = 0, positions_contradicted = 0;   // of tied photos with a recorded one
  std::size_t positions_off_claim = 0;                     // the same by less, where they claim to be better
  std::size_t attitudes = 0, attitudes_contradicted = 0;   // by where the optical axis points
  double median_error_m = 0.0, median_error_sigmas = 0.0;  // of recorded positions, horizontal

  std::size_t Lost() const { return readable - tied; }
  double DroppedShare() const;           // of the observations
  bool ContradictsPositions() const;     // most of them, of enough for a verdict
  double PositionsContradicted() const;  // share
  double AttitudesContradicted() const;
};

// Those that belong to the largest connected component and, once there are tracks, see enough of them.
// Components with photos of a map that stays are one: that map holds them.
PhotoSet TiedPhotos(const Attempt& attempt);
bool ShowsEnough(const PhotoFeatures* features);

// Of the photos as they were taken, in pixels.
double MedianWidthPx(const poses::PosedFlight& posed);

AttemptEvidence Weigh(const ExtractedFlight& extracted, const Attempt& attempt);

// Why the recorded poses are not to be believed for the flight as a whole; nothing: they hold.
// `max_lost_share`: of the readable photos that may stay lost.
std::optional<flight::Remark> WhyDoubted(const AttemptEvidence& by_records, double max_lost_share);

// Why the result of the images is not the one to take; nothing: it is.
std::optional<flight::Remark> WhyImagesLose(const AttemptEvidence& by_records,
                                            const AttemptEvidence& by_images);

// Recorded positions that most of an alignment contradicts by far more than they claim, be it centimetres;
// nothing: they agree.
std::optional<flight::Remark> ContradictionOf(const AttemptEvidence& evidence);

// An adjustment that had to drop most observations fits the few it kept, whatever its residual: what the
// records say holds the photos apart, or together, against what they show. Nothing: it kept enough.
std::optional<flight::Remark> DroppedOf(int observations, int dropped);

}  // namespace skyquilt::alignment
