// DoubtPhotos: what is odd about single photos, found by comparing them with the others: copies of another
// photo, blurred ones, pictures of another place. Nothing is dropped for it; the user is told, and the map
// prefers other photos where it can. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/scene/aligned_flight.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/photo_set.h"

namespace skyquilt::alignment {

struct PhotoDoubt {
  std::optional<int> copy_of;  // an earlier photo with the same picture
  // The fine detail that it shows, as a share of what others show of the same ground; nothing where too few
  // others do.
  std::optional<double> sharpness;
  bool is_blurred = false;         // far less sharp than others of the same ground
  bool shows_other_place = false;  // rich in detail, yet nothing in common with photos that overlap and agree
};

// `pairs` were compared; the links of the flight are those verified in the end, over `relief`.
std::vector<PhotoDoubt> DoubtPhotos(const MatchedFlight& input, const std::vector<PhotoPair>& pairs,
                                    const Relief& relief);

// What the user is to know of it, each going on from the photo's name.
std::vector<flight::Remark> DoubtsInRemarks(const PhotoDoubt& doubt, const std::vector<std::string>& names);
// Of the whole flight, with the photos' names; more than three copies are one thing to know: the aircraft
// hovered.
std::vector<flight::Remark> DoubtsInRemarks(const std::vector<PhotoDoubt>& doubts,
                                            const std::vector<std::string>& names);

// Takes photos out that no verified pair ties to the others and that lie so far away that the map would be
// mostly empty; each is listed with the reason. Never takes out more than a tenth. Which ones it took out.
PhotoSet LeaveOutFarAway(AlignedFlight& flight);

}  // namespace skyquilt::alignment
