// Georeference: where a registered block lies on Earth, by what there is: recorded positions, a third of
// which may be wrong; surveyed points; otherwise nothing but a stated guess. Which way is up, the ground
// itself says (a plane through most of the points), or recorded attitudes where they agree with each other;
// north likewise. Frame `enu` of the flight. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/alignment/estimators/similarity.h"
#include "core/alignment/scene/photo_set.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/scene/registration.h"

namespace skyquilt::alignment {

inline constexpr double kGuessedWidthM = 100.0;  // of the ground a photo shows, where nothing tells

struct GeoreferenceRecords {
  std::vector<PhotoRecord> photos;  // by photo
  // Surveyed points that two or more photos of the block show: world and enu.
  std::vector<PlacePair> control;
  double ground_z_in_enu_m = 0.0;
  bool trusts_heights = false;  // of the positions, up to a quarter of the flying height
  // Heights of the flight count from one; surveyed ones, which may from another, are brought to it.
  bool has_own_zero = false;
};

enum class Placing { kByPositions, kByControl, kByHeights, kByGuess };

struct BlockPlace {
  Similarity3 enu_from_world;
  Placing placing = Placing::kByGuess;
  PhotoSet holding;  // photos of this block whose position holds
  int positions = 0, positions_held = 0;
  double median_residual_m = 0.0;  // horizontal, of positions or surveyed points
  double spread_sigmas = 1.0;      // residual of the inlier positions in their stated sigmas
  bool knows_north = false;
  bool ignores_surveyed_heights = false;  // with them the block would lie on its side
};

// Of block number `block`. One that no photo is left of lies nowhere: kByGuess, by no position.
BlockPlace Georeference(const Registration& registration, int block, const GeoreferenceRecords& records);

}  // namespace skyquilt::alignment
