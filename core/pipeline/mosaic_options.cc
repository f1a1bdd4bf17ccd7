#include "core/pipeline/mosaic_options.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "core/flight/remarks/because.h"
#include "core/pipeline/job_option.h"

namespace skyquilt::pipeline {
namespace {

// More metres for a pixel than so many of the photos' own are centimetres, more likely.
constexpr double kMaxTimesCoarser = 20.0;

}  // namespace

const char* NameOf(MapGround ground) {
  return std::find_if(std::begin(kMapGrounds), std::end(kMapGrounds),
                      [&](const auto& one) { return one.second == ground; })
      ->first;
}

Result<void> MosaicOptions::Validate() const {
  const auto refuse = [](std::string message) {
    return Error{ErrorCode::kInvalidArgument, std::move(message), ""};
  };
  for (const JobOption& option : JobOptionTable()) {
    if (option.kind != JobOptionKind::kNumber && option.kind != JobOptionKind::kWhole) continue;
    const std::optional<double> value = option.get(*this);
    if (value && !option.Takes(*value))
      return refuse(fmt::format("The option {} is {}; it {}.", option.name, *value, option.Rule()));
  }
  if (origin && !(std::abs(origin->lat_deg) <= 85.0 && std::abs(origin->lon_deg) <= 180.0)) {
    return refuse(
        fmt::format("The origin is {}, {} but must be a latitude up to 85 and a longitude up to 180 degrees.",
                    origin->lat_deg, origin->lon_deg));
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
      {"--origin", origin ? fmt::format("{:.7f},{:.7f}", origin->lat_deg, origin->lon_deg) : ""},
      {"--dem", std::filesystem::path(dem_path).filename().string()}};
  for (const JobOption& option : JobOptionTable()) {
    if (!option.decides_of_map) continue;
    const std::optional<double> value = option.get(*this);
    std::string& word = words[option.Flag()];
    if (option.kind == JobOptionKind::kChoice) {
      word = option.choices[static_cast<std::size_t>(*value)];
    } else if (option.kind == JobOptionKind::kYesNo) {
      word = *value != 0.0 ? "yes" : "";
    } else if (value) {
      word = fmt::format("{:g}", *value);
    }
  }
  return words;
}

double MosaicOptions::OutputGsdM(double photos_gsd_m) const {
  const double wanted_m = gsd_m.value_or(photos_gsd_m);
  return not_finer_than_photos ? std::max(wanted_m, photos_gsd_m) : wanted_m;
}

}  // namespace skyquilt::pipeline
