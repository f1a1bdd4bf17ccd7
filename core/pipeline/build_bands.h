// BuildBands: the raster of bands beside a map: its captures' references lie where the map has them, the
// other bands are registered to them, and all are rendered as values through one geometry and one seam map. A
// flight of photos in colour has none. Blocking; the values do not depend on threads. Errors: kUnprocessable
// (no capture looks at the ground), kCancelled, those of the sink.
#pragma once

#include <optional>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/bands/band_sink.h"
#include "core/bands/captures.h"
#include "core/base/progress.h"
#include "core/flight/photos/photo_source.h"
#include "core/flight/remarks/remark.h"
#include "core/ground/ground_surface.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/flight_facts.h"

namespace skyquilt::pipeline {

// What the bands are rendered from.
struct BandedMap {
  bands::Captures captures;
  alignment::AlignedFlight references;        // as placed, of the captures alone
  std::vector<render::Thumbnail> thumbnails;  // of the references
  std::optional<geo::Boundary> boundary;      // that they are cut to
};

// How far off the vertical maps and bands show what a photo sees, radians: as the options say, and what no
// other photo has seen no further out than 55 degrees, since an error of the photo's angles grows with the
// square of the tangent towards the horizon.
double MaxLookRad(const alignment::AlignedPhoto& photo, const MosaicOptions& options);

// Where photos in colour show the ground too, the map for looking is drawn from them: references of bands
// show nothing of it (max_look_rad is 0).
void DrawColourAlone(const bands::Captures& captures, alignment::AlignedFlight& flight);

// Nothing for a flight without captures, or of which none was placed.
std::optional<BandedMap> BandedMapOf(const FlightFacts& facts, bands::Captures captures,
                                     const MosaicOptions& options);

struct BuiltBands {
  bands::BandsReport report;
  std::vector<flight::Remark> warnings;
};
Result<BuiltBands> BuildBands(const BandedMap& map, const ground::GroundSurface& ground,
                              const MosaicOptions& options, const flight::PhotoSource& source,
                              bands::BandSink& sink, Progress& progress);

}  // namespace skyquilt::pipeline
