// SetBandsApart: cameras that take each band as a picture of its own. Groups a flight's photos of single
// bands to captures and leaves of each capture one photo in the flight, the reference, which is placed like
// any photo and knows the names of the others, its companions, which follow it. The reference band is the one
// that most captures have, of equals the one that aligns best. A flight of photos in colour, or of one band
// alone, stays as it is. Reads the headers of band photos on `threads` threads; the result does not depend on
// how many. Never fails: a photo whose band cannot be read is left out with its reason. Beside it what is
// done to captures (ScaleBand) and told of them (BandsReport).
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/bands/band_facts.h"
#include "core/flight/flight.h"
#include "core/flight/remarks/remark.h"

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
  std::vector<Band> bands;  // by wavelength (the usual one where none is written), then by name
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

// What bands.tif holds and how well its bands lie on each other, for report.json.
struct BandReport {
  Band band;
  int pictures = 0;          // that have values
  int registered = 0;        // of those, laid on the reference by what they show
  int patches = 0;           // by so many places, all pictures together
  double residual_px = 0.0;  // what is left between band and reference, root mean square, pixels of the band
};

struct BandsReport {
  std::string reference_band;  // the one that was placed
  int captures = 0;            // that were placed
  int captures_total = 0;
  double gsd_m = 0.0;  // of the bands' pictures (median at the image centres)
  std::vector<BandReport> bands;
};

// By which factors a band's values are wrong, as several witnesses say: pictures of a panel, targets on the
// ground.
struct WitnessedFactors {
  std::map<std::string, std::vector<double>> by_group;                  // of the photos that they are said of
  std::function<std::string(const flight::Photo&)> group_of = nullptr;  // null: all are one, called ""
};

// Brings a band's values in `captures` to reflectance: the median counts for each group, that of all for
// those without a factor of their own, and is returned; where a group's are more than a tenth apart
// `warnings` tells. `by`: what the witnesses are, `method`: the same in words, for the band's. Precondition:
// at least one factor for each group that is named, all above 0.
double ScaleBand(Captures& captures, const std::string& band, const WitnessedFactors& factors, HeldAgainst by,
                 const std::string& method, std::vector<flight::Remark>& warnings);

// Names the bands whose values were held against nothing known, where those of others were: an index of both
// is off by a factor. Temperatures need nothing known.
std::optional<flight::Remark> BandsHeldAgainstNothing(const Captures& captures);

// What a list says of a band; nothing where it says nothing.
std::optional<double> ReflectanceOf(const flight::KnownReflectance& known, const std::string& band);

}  // namespace skyquilt::bands
