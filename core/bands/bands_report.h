// BandsReport: what bands.tif holds and how well its bands lie on each other, for report.json. A value; any
// thread.
#pragma once

#include <string>
#include <vector>

#include "core/bands/captures.h"

namespace skyquilt::bands {

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

}  // namespace skyquilt::bands
