#include "core/pipeline/mosaic_options.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "core/flight/remarks/because.h"

namespace skyquilt::pipeline {
namespace {

// More metres for a pixel than so many of the photos' own are centimetres, more likely.
constexpr double kMaxTimesCoarser = 20.0;

template <typename Names, typename Value>
const char* NameIn(const Names& names, Value value) {
  const auto found = std::find_if(std::begin(names), std::end(names),
                                  [&](const auto& name) { return name.second == value; });
  return found == std::end(names) ? "" : found->first;
}

}  // namespace

const char* NameOf(MapGround ground) { return NameIn(kMapGrounds, ground); }

Result<void> MosaicOptions::Validate() const {
  const auto refuse = [](std::string message) {
    return Error{ErrorCode::kInvalidArgument, std::move(message), ""};
  };
  if (gsd_m && !(*gsd_m >= 0.001 && *gsd_m <= 100.0)) {
    return refuse(fmt::format("The option gsd_m is {} but must be 0.001 to 100 metres.", *gsd_m));
  }
  if (origin && !(std::abs(origin->lat_deg) <= 85.0 && std::abs(origin->lon_deg) <= 180.0)) {
    return refuse(
        fmt::format("The origin is {}, {} but must be a latitude up to 85 and a longitude up to 180 degrees.",
                    origin->lat_deg, origin->lon_deg));
  }
  if (takeoff_height_amsl_m && !(*takeoff_height_amsl_m >= -500.0 && *takeoff_height_amsl_m <= 9000.0)) {
    return refuse(fmt::format("The take-off height is {} but must be -500 to 9000 metres above sea level.",
                              *takeoff_height_amsl_m));
  }
  if (jpeg_quality < 1 || jpeg_quality > 100) {
    return refuse(fmt::format("The quality is {} but must be 1 to 100.", jpeg_quality));
  }
  if (!(max_look_deg >= 10.0 && max_look_deg <= 75.0)) {
    return refuse(
        fmt::format("max_look_deg is {} but must be 10 to 75 degrees off the vertical", max_look_deg));
  }
  if (readout_s && !(*readout_s >= 0.0 && *readout_s <= 0.5)) {
    return refuse(
        fmt::format("The option readout_ms is {} but must be 0 to 500 milliseconds.", 1e3 * *readout_s));
  }
  if (!(feather_m >= 0.0 && feather_m <= 100.0)) {
    return refuse(fmt::format("The option feather_m is {} but must be 0 to 100 metres.", feather_m));
  }
  constexpr std::int64_t kMinMemory = std::int64_t{256} << 20;
  if (max_memory_bytes < kMinMemory) {
    return refuse(
        fmt::format("The memory limit is {} bytes but must be at least 256 MiB.", max_memory_bytes));
  }
  if (threads < 0 || threads > 1024)
    return refuse(fmt::format("The number of threads is {} but must be 0 (all cores) to 1024.", threads));
  return {};
}

Result<void> MosaicOptions::CheckGsd(double photos_gsd_m) const {
  if (!gsd_m || any_gsd || !(*gsd_m > kMaxTimesCoarser * photos_gsd_m)) return {};
  return flight::Because(
      ErrorCode::kInvalidArgument,
      {flight::RemarkCode::kFailMuchCoarser,
       {{"asked_m", *gsd_m}, {"photos_cm", 100.0 * photos_gsd_m}, {"times", *gsd_m / photos_gsd_m}}});
}

std::map<std::string, std::string> MosaicOptions::InWords() const {
  std::map<std::string, std::string> words = {
      {"--method", NameIn(kAlignMethods, method)},
      {"--format", NameIn(kTileFormats, encoding)},
      {"--quality", std::to_string(jpeg_quality)},
      {"--surface", NameOf(surface)},
      {"--max-look-deg", fmt::format("{:g}", max_look_deg)},
      {"--readout-ms", readout_s ? fmt::format("{:g}", 1e3 * *readout_s) : ""},
      {"--origin", origin ? fmt::format("{:.7f},{:.7f}", origin->lat_deg, origin->lon_deg) : ""},
      {"--landed-at-start", landed_at_start ? "yes" : ""},
      {"--takeoff-height-m", takeoff_height_amsl_m ? fmt::format("{:g}", *takeoff_height_amsl_m) : ""},
      {"--dem", std::filesystem::path(dem_path).filename().string()}};
  return words;
}

double MosaicOptions::OutputGsdM(double photos_gsd_m) const {
  const double wanted_m = gsd_m.value_or(photos_gsd_m);
  return not_finer_than_photos ? std::max(wanted_m, photos_gsd_m) : wanted_m;
}

}  // namespace skyquilt::pipeline
