// TakeCorrectedHeights: programs of post-processing (exiftool with their lists, Emlid Studio, REDtoolbox,
// Klau) write the corrected place into EXIF and leave the maker's XMP, which has the old one. The place of
// such a photo is EXIF's, and so is its altitude then: the old one may be tens of metres off, or count from
// another zero. That it is so is told by a flight, not by one photo: EXIF and XMP differ in place and in
// altitude, by more than the steps in which they are written, and the places by a shift that all photos
// share, whichever way they flew. A firmware that writes the place of another moment or of another antenna
// moves them with the way of flight or with the aircraft's nose: such heights stay the maker's, as do those
// of a flight in one direction, which tells no shift from the other, and altitudes that are heights above
// take-off. What EXIF's altitude counts from: what its reference names (Exif 3); else what brings it near to
// the altitudes in XMP, where the geoid tells the two zeros apart; else the ellipsoid is assumed, as these
// programs write it. Which it was is said. Metres. Any thread; never fails.
#pragma once

#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::flight {

// Changes the absolute heights of the photos whose EXIF was corrected, and says so in `warnings`. The photos
// are in the order in which they were taken.
void TakeCorrectedHeights(std::vector<Photo>& photos, std::vector<Remark>& warnings);

// Programs that know no altitude write 0, as cameras without one do. Where all photos have it, three or more,
// none counts: the ground would lie a flight height below the sea. Says so in `warnings`.
void DropAltitudesOfZero(std::vector<Photo>& photos, std::vector<Remark>& warnings);

}  // namespace skyquilt::flight
