// SetBandsApart: cameras that take each band as a picture of its own. Groups a flight's photos of single
// bands to captures and leaves of each capture one photo in the flight, the reference, which is placed like
// any photo; the others, its companions, follow it. The reference band is the one that most captures have, of
// equals the one that aligns best. A flight of photos in colour, or of one band alone, stays as it is. Reads
// the headers of band photos on `threads` threads; the result does not depend on how many. Never fails: a
// photo whose band cannot be read is left out with its reason.
#pragma once

#include <string>
#include <vector>

#include "core/bands/band_facts.h"
#include "core/flight/flight.h"

namespace skyquilt::bands {

struct BandPhoto {
  flight::Photo photo;
  BandFacts facts;
};

// One release of the shutters.
struct Capture {
  std::string reference;          // name of the photo that is placed
  std::vector<BandPhoto> photos;  // that have values, one per band at most, in the order of the bands
};

// What of known reflectance a band's values were held against.
enum class HeldAgainst { kNothing, kPanel, kTargets };

struct Band {
  std::string name;
  std::optional<double> wavelength_nm;
  std::optional<double> width_nm;
  Calibration calibration = Calibration::kLevels;  // of all photos that have values
  std::string method;
  HeldAgainst held_against = HeldAgainst::kNothing;
};

struct Captures {
  std::vector<Band> bands;  // by wavelength, then by name
  std::string reference_band;
  std::vector<Capture> captures;              // in the order of the flight
  std::vector<flight::GroundTarget> targets;  // ground of known reflectance
  std::vector<BandPhoto> panels;              // pictures of calibration panels, left out of the flight
  bool empty() const { return captures.empty(); }
};

Captures SetBandsApart(flight::Flight& flight, int threads);

// Captures of which `shows_panel` says so go to `panels`, their photos out of the flight. Where that would be
// all of them nothing is changed: false.
bool SetPanelsApart(const std::vector<bool>& shows_panel, Captures& apart, flight::Flight& flight);

}  // namespace skyquilt::bands
