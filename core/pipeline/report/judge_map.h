// JudgeMap: how true a map is and what limits it: the one place where that is computed, for finished maps
// and, as a forecast, for flights that are only inspected. What supports the absolute accuracy, the first
// that there is: check points; control points that fit each other (each left out in turn, from four on);
// recorded positions; nothing.
//
// By positions: positions_error.h. The stated radius is 1.515 sigma: a circle that holds 68.3 % of a normal
// error of two axes. Of check points it is the root mean square of what the map misses them by, no less than
// survey and marks err by, and wider where they are few; where they do not tell of all of the map (fewer than
// three, or side by side), with what else is known of it, and they silence nothing that limits it. Of groups
// of photos without ties between them it holds that share of all photos, by what places each group. Pure.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/aligned_flight.h"
#include "core/flight/remarks/remark.h"
#include "core/pipeline/report/map_quality.h"
#include "core/poses/evidence/records_apart.h"
#include "core/poses/pose_report.h"
#include "core/render/seams/seam_shift.h"

namespace skyquilt::pipeline {

// Of what places a map: a check point that it misses by more contradicts it.
inline constexpr double kCheckSigmas = 5.0;

struct JudgedMap {
  const alignment::AlignedFlight& flight;  // its photos with their records
  const poses::PoseReport& poses;
  const alignment::AlignReport* alignment = nullptr;  // null: no photos were compared
  render::SeamShift seams = {};
  double gsd_m = 0.0;        // of the map
  double photo_gsd_m = 0.0;  // of its photos, in which points and marks are found
  bool is_placed = true;
  bool is_by_images = false;
  bool is_by_hand = false;
  bool is_forecast = false;  // nothing was aligned yet: as if all will be
};

MapQuality JudgeMap(const JudgedMap& map);

// That the map may lean about the one line of its positions, where this is most of its stated error; that the
// positions, or their heights, jump.
std::vector<flight::Remark> RemarksOnPositions(const JudgedMap& map);

// Of each surveyed point of the alignment: by how much the map may miss it before the two contradict each
// other, so much more than what places the map and the point's own survey err by. Nothing: it checks nothing,
// or nothing states how far off the map is without the points that check it.
std::vector<std::optional<double>> MissesAllowedM(const JudgedMap& map);

// How far the recorded positions lie from where surveyed points put the map. Nothing: no point places it, or
// too few positions are recorded.
std::optional<poses::RecordsApart> RecordsApartOfControl(const JudgedMap& map);

// Which aligned photos hold together, by the points that they share. Of two groups that share none, as of two
// fields, what places one says nothing of the other. Neither what pictures show as a whole, which holds them
// loosely, nor a photo that lies by its pose makes one group of two.
struct TiedGroups {
  std::map<std::string, int> photos;  // numbers of the aligned ones, by name
  std::vector<int> of_photo;          // its group; negative: none
  int count = 0;

  int OfPhotoNamed(const std::string& name) const;
};
TiedGroups GroupsByTies(const std::vector<alignment::AlignedPhoto>& photos,
                        const std::vector<alignment::AlignPairReport>& pairs);

// Aligned photos are as far off as the map is; those that lie by their records may be further off, and say so
// already. Where nothing says how far, the photos' own numbers stay.
void TellPhotos(const MapQuality& quality, alignment::AlignedFlight& flight);

// Where neither a position nor a surveyed point places the map, records are of another place than it has.
alignment::ErrorsKnown ErrorsKnownOf(const AbsoluteAccuracy& absolute);

}  // namespace skyquilt::pipeline
