// PreviewPhoto: one photo on the map within a fraction of a second of its arrival: coarse, on a plane, placed
// by its recorded pose alone. The same renderer as the map's, so a preview lies where the map will lie, up to
// the pose. Blocking, one thread; any number of photos at a time. Errors: those of decoding and of the sink;
// kUnprocessable when the photo does not look at the ground.
#pragma once

#include <cstddef>
#include <optional>

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/pyramid/tile_sink.h"

namespace skyquilt::pipeline {

struct PreviewOptions {
  int longer_side_px = 1024;    // about so many map pixels across the photo
  std::optional<double> gsd_m;  // of the map, instead: so that photos share their zooms
  int jpeg_quality = 75;
};

struct PhotoPreview {
  geo::LatLonBounds bounds;
  int min_zoom = 0;
  int max_zoom = 0;
  int tile_size_px = 256;
  std::int64_t tiles = 0;
};

// `placed` is the flight so far (AlignByPoseOnly), `photo` an index into it.
Result<PhotoPreview> PreviewPhoto(const alignment::AlignedFlight& placed, std::size_t photo,
                                  const flight::PhotoSource& source, const PreviewOptions& options,
                                  pyramid::TileSink& sink);

}  // namespace skyquilt::pipeline
