// CompareMethods: stitches one flight by every method, each in a process of its own, so that time and memory
// are measured per method, and reports them as one table and one picture. Blocking. Precondition: the process
// has started no threads. Errors: kIo; kCancelled. A method that fails has its reason in the table.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/read_flight.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/pipeline/mosaic_options.h"
#include "server/comparison/truth_error.h"

namespace skyquilt::server {

struct MethodOutcome {
  std::string method;
  std::filesystem::path folder;
  std::string failure;  // empty: it made a map
  std::string note;     // of a method that makes no map: what it found
  int photos = 0;       // given
  int placed = 0;       // on the map
  int aligned = 0;      // of those by images
  int pieces = 0;       // 0: not counted by this method
  std::optional<double> residual_px;
  std::optional<double> seam_median_m, seam_p90_m;
  double gsd_m = 0.0;
  geo::LatLonBounds bounds;
  int min_zoom = 0, max_zoom = 0;
  double wall_s = 0.0;
  double cpu_s = 0.0;
  std::int64_t peak_memory_bytes = 0;
  std::optional<TruthError> truth;
};

// Each method's map and report go into out_dir/METHOD. Where a log has raw inertial samples, the last row is
// dead reckoning between captures (reckon_row.h), without a map. `truth_json`: of a simulated flight; may be
// empty.
Result<std::vector<MethodOutcome>> CompareMethods(const std::vector<flight::InputFile>& files,
                                                  const pipeline::MosaicOptions& options,
                                                  const std::string& truth_json,
                                                  const std::filesystem::path& out_dir);

std::string ComparisonMarkdown(const std::vector<MethodOutcome>& outcomes);
std::string ComparisonJson(const std::vector<MethodOutcome>& outcomes);

}  // namespace skyquilt::server
