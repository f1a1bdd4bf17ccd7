// InspectFlight: the verdict before any pixel is decoded: what the photos record, what the logs hold, how the
// two are tied together, what the map will be, what it will cost and what is wrong. Of photos it reads
// headers only; a second or two for a thousand photos. Blocking.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/logs/describe_log.h"
#include "core/flight/read_flight.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/dem_source.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/map_quality.h"
#include "core/poses/pose_report.h"

namespace skyquilt::pipeline {

struct FlightVerdict {
  int photos_readable = 0;
  int photos_placeable = 0;            // by their records
  int photos_by_images = 0;            // no record places them; what they show may
  std::map<std::string, int> cameras;  // "make model, 4000 x 2250 px, focal 2340 px (sensor_table)"
  // Photos by where what is used of them comes from: "exif", a file, "none".
  std::map<std::string, int> position_sources;
  std::map<std::string, int> attitude_sources;
  std::vector<flight::LogFacts> logs;
  std::vector<flight::ListUse> lists;         // of positions and of surveyed points: what became of each
  std::vector<std::string> gcp_lists;         // "gcp_list.txt: 5 points, 23 sightings"
  std::vector<std::string> elevation_models;  // names of files
  poses::PoseReport poses;                    // how the poses were found; empty when none could be
  std::string first_capture, last_capture;    // as CaptureSpan has them; empty when unknown
  std::string height_rule;
  double lowest_m = 0.0, highest_m = 0.0;  // above ground
  double gsd_m = 0.0;
  double area_m2 = 0.0;                   // of the ground that some photo sees
  std::optional<double> forward_overlap;  // median, 0..1, with the next photo in time; nothing: there is none
  double mean_photos_per_point = 0.0;
  // What the records claim before any photo is looked at. It is not the map's accuracy, which photos that
  // contradict them, or surveyed points, make another.
  MapQuality by_records;
  int max_zoom = 0;
  int tile_size_px = 256;
  double output_megapixels = 0.0;
  double expected_seconds = 0.0;  // on this machine's cores
  double expected_memory_mib = 0.0;
  std::vector<flight::LeftOutPhoto> left_out;
  std::vector<flight::Remark> warnings;
};

Result<FlightVerdict> InspectFlight(const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                    Progress& progress, const geo::DemSource* dem = nullptr);

// The map's status, where the records alone decide it: too few places, or none, and no surveyed points.
std::optional<MapStatus> ForeseenStatus(const FlightVerdict& verdict);

std::string VerdictText(const FlightVerdict& verdict);
std::string VerdictJson(const FlightVerdict& verdict);

}  // namespace skyquilt::pipeline
