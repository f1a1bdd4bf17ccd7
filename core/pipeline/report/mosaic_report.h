// MosaicReport: what was made and how good it is. Prints itself as report.json (schema:
// core/pipeline/report.schema.json) and the photos as GeoJSON (RFC 7946). A value; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/aligned_flight.h"
#include "core/bands/captures.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/ground/ground_surface.h"
#include "core/ground/model_ground_report.h"
#include "core/pipeline/report/ground_choice.h"
#include "core/pipeline/report/map_quality.h"
#include "core/poses/pose_report.h"
#include "core/render/seams/seam_shift.h"

namespace skyquilt::pipeline {

// What came of matching heights.
struct SurfaceReport {
  double cell_m = 0.0;
  // Of the cells that a photo shows: those whose height several photos agree on; the others were filled from
  // around.
  double measured_share = 0.0;
  std::optional<double> contour_interval_m = {};  // of the ground, where that was written
};

// When the photos of a flight were taken, from the first to the last, as the clock on the wall there showed
// it: "2015-10-27T09:31:02-04:00". With "Z" where the zone is not known, without either where the clock was a
// local one of an unknown zone.
struct CaptureSpan {
  std::string first, last;
};

// Photos without a time are passed over; where some have UTC and some do not, those that have it count.
std::optional<CaptureSpan> CaptureSpanOf(const std::vector<const flight::Photo*>& photos);

struct StageTiming {
  std::string stage;
  double wall_s = 0.0;
  double cpu_s = 0.0;  // of all threads
};

struct MosaicReport {
  std::string title;
  int photos_total = 0;
  int photos_aligned = 0;
  int photos_pose_only = 0;
  int photos_left_out = 0;
  std::vector<flight::LeftOutPhoto> left_out_photos;
  std::optional<CaptureSpan> captured;  // of the photos in the map
  // What the map shows of the ground: as was asked for, never finer than its photos (median at the image
  // centres) nor than its pixels.
  double gsd_m = 0.0;
  double area_m2 = 0.0;  // covered ground
  geo::LatLonBounds bounds;
  int min_zoom = 0;
  int max_zoom = 0;
  int tile_size_px = 256;  // above zoom 22 the tiles grow instead of the zoom
  std::int64_t tile_count = 0;
  std::int64_t blocks = 0;       // the components that the map is rendered in
  std::int64_t blocks_kept = 0;  // of those, taken over from an earlier run
  std::string height_rule;
  bool is_placed = true;  // false: nothing says where on Earth the flight was; scale and north are right
  MapQuality quality;
  std::vector<StageTiming> timings;
  std::int64_t peak_memory_bytes = 0;
  std::vector<flight::Remark> warnings;
  poses::PoseReport poses_report;
  ground::ModelGroundReport ground_report;
  render::SeamShift seam_shift;
  std::optional<alignment::AlignReport> align_report;  // nothing where photos lie by their poses alone
  std::optional<bands::BandsReport> bands;             // of bands.tif; nothing for photos in colour
  std::optional<SurfaceReport> surface;                // of dsm.tif; nothing where nobody asked for it
  std::optional<GroundChoice> ground_choice;           // of --surface auto alone
};

// Do heights that are told count as those of the surveyed points that place the map, and not from the zero of
// the flight's records? What is added to the latter then; else 0.
bool CountsAsSurvey(const MosaicReport& report);
double RaisedM(const MosaicReport& report);

std::string ReportJson(const MosaicReport& report);
// A FeatureCollection with one footprint polygon a photo, on the modelled ground. How far off photos are is
// said where `absolute` tells (ErrorsKnownOf).
std::string PhotosGeoJson(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                          const AbsoluteAccuracy& absolute);

}  // namespace skyquilt::pipeline
