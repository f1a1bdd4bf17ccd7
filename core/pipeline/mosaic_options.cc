#include "core/pipeline/mosaic_options.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>

#include "core/base/text/plain_text.h"
#include "core/flight/remarks/because.h"

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

namespace {

// As JobOption::get gives it.
std::optional<double> ValueIn(const JobOption& option, const std::string& word) {
  if (option.kind == JobOptionKind::kYesNo) return word == "yes" ? 1.0 : 0.0;
  if (option.kind != JobOptionKind::kChoice) return ParseNumber<double>(word);
  const auto found = std::find(option.choices.begin(), option.choices.end(), word);
  if (found == option.choices.end()) return std::nullopt;
  return static_cast<double>(found - option.choices.begin());
}

}  // namespace

void MosaicOptions::TakeWords(const std::map<std::string, std::string>& words,
                              const std::function<bool(const std::string&)>& taken) {
  for (const JobOption& option : JobOptionTable()) {
    const auto found = words.find(option.Flag());
    if (!option.decides_of_map || found == words.end() || !taken(found->first)) continue;
    if (const std::optional<double> value = ValueIn(option, found->second)) option.set(*value, this);
  }
  const auto place = words.find("--origin");
  if (place == words.end() || !taken(place->first)) return;
  const std::string_view text = place->second;
  const std::size_t comma = std::min(text.find(','), text.size());
  const auto lat_deg = ParseNumber<double>(text.substr(0, comma));
  const auto lon_deg = ParseNumber<double>(text.substr(std::min(comma + 1, text.size())));
  if (lat_deg && lon_deg) origin = geo::LatLon{*lat_deg, *lon_deg};
}

double MosaicOptions::OutputGsdM(double photos_gsd_m) const {
  const double wanted_m = gsd_m.value_or(photos_gsd_m);
  return not_finer_than_photos ? std::max(wanted_m, photos_gsd_m) : wanted_m;
}

namespace {

using enum JobOptionKind;

template <auto kMember>
std::optional<double> Get(const MosaicOptions& options) {
  return options.*kMember;
}

template <auto kMember>
void Set(double value, MosaicOptions* options) {
  options->*kMember = value;
}

void SetQuality(double value, MosaicOptions* options) { options->jpeg_quality = static_cast<int>(value); }

template <bool MosaicOptions::*kMember>
void SetYesNo(double value, MosaicOptions* options) {
  options->*kMember = value != 0.0;
}

std::optional<double> GetReadoutMs(const MosaicOptions& options) {
  if (!options.readout_s) return std::nullopt;
  return 1e3 * *options.readout_s;
}

void SetReadoutMs(double value, MosaicOptions* options) { options->readout_s = 1e-3 * value; }

template <const auto& kNames>
constexpr auto WordsIn() {
  std::array<const char*, std::size(kNames)> words{};
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = kNames[i].first;
  return words;
}

template <const auto& kNames>
inline constexpr auto kWordsIn = WordsIn<kNames>();

template <const auto& kNames, auto kMember>
std::optional<double> GetChoice(const MosaicOptions& options) {
  const auto found = std::find_if(std::begin(kNames), std::end(kNames),
                                  [&](const auto& name) { return name.second == options.*kMember; });
  return static_cast<double>(found - std::begin(kNames));
}

template <const auto& kNames, auto kMember>
void SetChoice(double value, MosaicOptions* options) {
  options->*kMember = kNames[static_cast<std::size_t>(value)].second;
}

using Options = MosaicOptions;

// A row: what it is, how it is told, where it stands.
// clang-format off
constexpr JobOption kTable[] = {
    {.name = "gsd_m", .kind = kNumber, .unit = " metres", .least = 0.001, .most = 100.0, .may_be_open = true,
     .help = "Ground size of a pixel in metres. More than 20 times that of the photos is refused, unless any_gsd says that it is meant",
     .get = Get<&Options::gsd_m>, .set = Set<&Options::gsd_m>},
    {.name = "any_gsd", .kind = kYesNo,
     .help = "A gsd_m far coarser than the photos is meant",
     .get = Get<&Options::any_gsd>, .set = SetYesNo<&Options::any_gsd>},
    {.name = "not_finer_than_photos", .kind = kYesNo,
     .help = "gsd_m counts only where it is coarser than the photos' own pixels",
     .get = Get<&Options::not_finer_than_photos>, .set = SetYesNo<&Options::not_finer_than_photos>},
    {.name = "max_look_deg", .kind = kNumber, .unit = " degrees off the vertical", .least = 10.0, .most = 75.0, .decides_of_map = true,
     .help = "Nothing is drawn that a photo sees further off the vertical than this, in degrees",
     .get = Get<&Options::max_look_deg>, .set = Set<&Options::max_look_deg>},
    {.name = "readout_ms", .kind = kNumber, .unit = " milliseconds", .least = 0.0, .most = 500.0, .may_be_open = true, .decides_of_map = true,
     .help = "Rolling shutter: milliseconds from reading a photo's first row to its last, 0 for none; without it as known of the camera. Undone where photos or logs say how fast the aircraft flew",
     .get = GetReadoutMs, .set = SetReadoutMs},
    {.name = "format", .kind = kChoice, .decides_of_map = true, .choices = kWordsIn<kTileFormats>,
     .help = "Of the tiles. auto: JPEG inside, WebP with alpha at the fringe, which is smallest; jpeg-png: PNG at the fringe, for programs that open the map's MBTiles or PMTiles themselves and know no WebP; webp: WebP throughout",
     .get = GetChoice<kTileFormats, &Options::encoding>, .set = SetChoice<kTileFormats, &Options::encoding>},
    {.name = "quality", .kind = kWhole, .least = 1.0, .most = 100.0, .decides_of_map = true,
     .help = "JPEG or WebP quality of the tiles",
     .get = Get<&Options::jpeg_quality>, .set = SetQuality},
    {.name = "method", .kind = kChoice, .decides_of_map = true, .choices = kWordsIn<kAlignMethods>,
     .help = "How photos are placed. auto: poses refined by image features, and where angles, heights or positions are missing or wrong photos placed by what they show alone; images: all photos placed by what they show alone; imu: recorded poses alone, no pixel compared",
     .get = GetChoice<kAlignMethods, &Options::method>, .set = SetChoice<kAlignMethods, &Options::method>},
    {.name = "surface", .kind = kChoice, .decides_of_map = true, .choices = kWordsIn<kMapGrounds>,
     .help = "smooth: photos are projected to the ground, and what stands on it leans as it does in them; dense: houses, walls and trees stand upright (a true orthophoto), by heights of every two pixels that are matched in the photos first, which takes several times as long; auto: dense where what stands on the ground leans by more than two pixels and three photos see most of it. A flight that would be cut into units is made by one worker where it is not smooth",
     .get = GetChoice<kMapGrounds, &Options::surface>, .set = SetChoice<kMapGrounds, &Options::surface>},
    {.name = "heights", .kind = kChoice, .choices = kWordsIn<kMapHeights>,
     .help = "Heights beside the map: of ground, roofs and trees as the photos show them (dsm), or those and of the ground below with its contours (dtm). Takes several times as long as the map; a flight that would be cut into units is made by one worker then. A job that only moves a map (place) makes those anew that the map has",
     .get = GetChoice<kMapHeights, &Options::heights>, .set = SetChoice<kMapHeights, &Options::heights>},
    {.name = "origin"},
    {.name = "boundary"},
    {.name = "takeoff_height_m", .kind = kNumber, .unit = " metres above sea level", .least = -500.0, .most = 9000.0, .may_be_open = true, .decides_of_map = true,
     .help = "Height of the place of take-off in metres above sea level (EGM96), where photos record heights above take-off alone, or wrong ones above sea level",
     .get = Get<&Options::takeoff_height_amsl_m>, .set = Set<&Options::takeoff_height_amsl_m>},
    {.name = "landed_at_start", .kind = kYesNo, .decides_of_map = true,
     .help = "A flight without any position landed where it took off",
     .get = Get<&Options::landed_at_start>, .set = SetYesNo<&Options::landed_at_start>},
    {.name = "place"},
    {.name = "layers"},
    {.name = "import_file"},
};
// clang-format on

}  // namespace

std::string JobOption::Flag() const {
  std::string flag = fmt::format("--{}", name);
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

std::string JobOption::Rule() const {
  if (kind == kYesNo) return "must be true or false";
  if (kind != kChoice)
    return fmt::format("must be a {} between {:g} and {:g}{}", kind == kWhole ? "whole number" : "number",
                       least, most, unit);
  std::string rule = "must be";
  for (std::size_t i = 0; i < choices.size(); ++i) {
    rule += fmt::format("{} \"{}\"", i == 0 ? "" : i + 1 == choices.size() ? " or" : ",", choices[i]);
  }
  return rule;
}

std::span<const JobOption> JobOptionTable() { return kTable; }

const JobOption* FindJobOption(std::string_view name) {
  const auto found = std::find_if(std::begin(kTable), std::end(kTable),
                                  [&](const JobOption& one) { return one.name == name; });
  return found == std::end(kTable) ? nullptr : found;
}

}  // namespace skyquilt::pipeline
