// DoubtPhotos: what is odd about single photos, found by comparing them with the others: copies of another
// photo, blurred ones, pictures of another place. Nothing is dropped for it; the user is told, and the map
// prefers other photos where it can. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/scene/aligned_flight.h"
#include "core/alignment/scene/photo_set.h"
#include "core/alignment/scene/priors.h"

namespace skyquilt::alignment {

// Into the findings of the flight, one for each photo. `pairs` were compared; its links are those verified in
// the end, over `relief`.
void DoubtPhotos(const std::vector<PhotoPair>& pairs, const Relief& relief, MatchedFlight& flight);

// What the user is to know of it, each going on from the photo's name.
std::vector<flight::Remark> DoubtsInRemarks(const PhotoFindings& findings,
                                            const std::vector<std::string>& names);
// Of the whole flight, with the photos' names; more than three copies are one thing to know: the aircraft
// hovered.
std::vector<flight::Remark> DoubtsInRemarks(const std::vector<PhotoFindings>& findings,
                                            const std::vector<std::string>& names);

// Takes photos out that no verified pair ties to the others and that lie so far away that the map would be
// mostly empty; each is listed with the reason. Never takes out more than a tenth. Which ones it took out.
PhotoSet LeaveOutFarAway(AlignedFlight& flight);

}  // namespace skyquilt::alignment
