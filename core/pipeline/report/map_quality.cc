#include "core/pipeline/report/map_quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/base/text/json_io.h"
#include "core/base/text/printable.h"

namespace skyquilt::pipeline {
namespace {

using QualityDocument = nlohmann::ordered_json;

constexpr double kMaxSigmaM = 1e8;
constexpr int kMaxSupportCount = 100'000'000;
constexpr const char* kUnknownOfImported = "unknown: an imported map";

std::string Number(double value) {
  return value < 100.0 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value);
}

// None without a name.
static_assert(std::size(kMapStatuses) == static_cast<std::size_t>(MapStatus::kUnknown) + 1);
static_assert(std::size(kAbsoluteSupports) == static_cast<std::size_t>(AbsoluteSupport::kCheckPoints) + 1);
static_assert(std::size(kRelativeSupports) == static_cast<std::size_t>(RelativeSupport::kSeams) + 1);
static_assert(std::size(kLimitKinds) == static_cast<std::size_t>(LimitKind::kPoseOnly) + 1);

template <typename Names, typename Kind>
std::string_view NameIn(const Names& names, Kind kind) {
  const auto found =
      std::find_if(std::begin(names), std::end(names), [&](const auto& one) { return one.first == kind; });
  SKYQUILT_CHECK(found != std::end(names), "a word of a map's quality has no name");
  return found->second;
}

template <typename Names>
auto KindNamed(const Names& names, const QualityDocument& json) {
  const auto& name = json.get_ref<const std::string&>();
  const auto found =
      std::find_if(std::begin(names), std::end(names), [&](const auto& one) { return one.second == name; });
  if (found == std::end(names)) throw QualityDocument::other_error::create(500, "an unknown word", nullptr);
  return found->first;
}

int SupportCount(const QualityDocument& json) {
  const auto count = json.get<double>();
  if (!(count >= 0.0 && count <= kMaxSupportCount) || count != std::floor(count))
    throw QualityDocument::other_error::create(500, "a count is none", nullptr);
  return static_cast<int>(count);
}

std::optional<double> SupportedNumber(const QualityDocument& json) {
  if (json.is_null()) return std::nullopt;
  const auto value = json.get<double>();
  if (!(value >= 0.0 && value <= kMaxSigmaM))
    throw QualityDocument::other_error::create(500, "an accuracy that no map has", nullptr);
  return value;
}

QualityDocument NumberOrNull(const std::optional<double>& value) {
  return value ? QualityDocument(*value) : QualityDocument(nullptr);
}

MapQuality QualityOf(const QualityDocument& json) {
  MapQuality quality;
  quality.status = KindNamed(kMapStatuses, json.at("status"));
  const QualityDocument& absolute = json.at("absolute");
  quality.absolute = {SupportedNumber(absolute.at("sigma_m")),
                      KindNamed(kAbsoluteSupports, absolute.at("by")), SupportCount(absolute.at("count"))};
  const QualityDocument& relative = json.at("relative");
  quality.relative = {SupportedNumber(relative.at("error_m")), SupportedNumber(relative.at("error_px")),
                      KindNamed(kRelativeSupports, relative.at("by")), SupportCount(relative.at("count"))};
  const QualityDocument& limits = json.at("limits");
  if (!limits.is_array() || limits.size() > std::size(kLimitKinds))
    throw QualityDocument::other_error::create(500, "limits are none", nullptr);
  for (const QualityDocument& limit : limits) {
    quality.limits.push_back({KindNamed(kLimitKinds, limit.at("kind")), SupportCount(limit.at("count")),
                              SupportCount(limit.at("of"))});
  }
  return quality;
}

}  // namespace

bool MapQuality::IsLimitedBy(LimitKind kind) const {
  return std::any_of(limits.begin(), limits.end(), [&](const MapLimit& limit) { return limit.kind == kind; });
}

std::string_view NameOf(AbsoluteSupport support) { return NameIn(kAbsoluteSupports, support); }
std::string_view NameOf(RelativeSupport support) { return NameIn(kRelativeSupports, support); }
std::string_view NameOf(MapStatus status) { return NameIn(kMapStatuses, status); }
std::string_view NameOf(LimitKind kind) { return NameIn(kLimitKinds, kind); }

double OfTwoDigits(double value) {
  if (!std::isfinite(value) || !(value > 0.0)) return 0.0;
  const std::string text = fmt::format("{:.1e}", value);
  double rounded = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return rounded;
}

std::string AccuracyText(double metres) {
  const double of_two = OfTwoDigits(metres);
  return of_two < 1.0 ? Number(OfTwoDigits(100.0 * of_two)) + " cm" : Number(of_two) + " m";
}

std::string AbsoluteInWords(const MapQuality& quality) {
  const AbsoluteAccuracy& absolute = quality.absolute;
  const int count = absolute.count;
  if (quality.status == MapStatus::kUnknown) return kUnknownOfImported;
  std::string by;
  switch (absolute.by) {
    case AbsoluteSupport::kNone:
      return "unknown: no positions";
    case AbsoluteSupport::kHand:
      if (!absolute.sigma_m) return "unknown: placed by hand";
      by = "reckoning from a given place";
      break;
    case AbsoluteSupport::kGnss:
      by = Counted(count, "position") + " of GNSS";
      break;
    case AbsoluteSupport::kRtk:
      by = Counted(count, "position") + " of RTK or PPK";
      break;
    case AbsoluteSupport::kControlPoints:
      by = Counted(count, "control point");
      break;
    case AbsoluteSupport::kCheckPoints:
      by = Counted(count, "check point");
      break;
  }
  if (!absolute.sigma_m) {
    const auto few = std::find_if(quality.limits.begin(), quality.limits.end(), [](const MapLimit& limit) {
      return limit.kind == LimitKind::kFewPositions;
    });
    if (few == quality.limits.end()) {  // they are enough for the place
      return quality.IsLimitedBy(LimitKind::kScaleGuessed) ? "unknown: the scale is a guess"
                                                           : "unknown: north is a guess";
    }
    return fmt::format("unknown: only {} of {} with a position", count, Counted(few->of, "photo"));
  }
  return fmt::format("+-{} (1 sigma), by {}", AccuracyText(*absolute.sigma_m), by);
}

std::string RelativeInWords(const MapQuality& quality) {
  const RelativeAccuracy& relative = quality.relative;
  if (quality.status == MapStatus::kUnknown) return kUnknownOfImported;
  if (relative.by == RelativeSupport::kNone || !relative.error_px)
    return "unknown: no photos are tied to each other";
  const std::string pixels = Number(*relative.error_px) + " px";
  return fmt::format(
      "{}, {}", relative.error_m ? fmt::format("{} ({})", AccuracyText(*relative.error_m), pixels) : pixels,
      relative.by == RelativeSupport::kSeams ? "at " + Counted(relative.count, "place") + " along seams"
                                             : "at " + Counted(relative.count, "tie point"));
}

std::string_view StatusInWords(MapStatus status) {
  constexpr std::array kWords = {"Ready to use", "Usable, with limits", "Place in doubt", "Not georeferenced",
                                 "Accuracy not known"};
  static_assert(kWords.size() == static_cast<std::size_t>(MapStatus::kUnknown) + 1);
  return kWords[static_cast<std::size_t>(status)];
}

std::string QualityInWords(const MapQuality& quality) {
  return fmt::format("{}. Absolute accuracy: {}. Relative: {}.", StatusInWords(quality.status),
                     AbsoluteInWords(quality), RelativeInWords(quality));
}

std::string LimitInWords(const MapLimit& limit) {
  const int count = limit.count, of = limit.of;
  switch (limit.kind) {
    case LimitKind::kNotGeoreferenced:
      return "Nothing says where on Earth the map lies.";
    case LimitKind::kScaleGuessed:
      return "The scale is a guess: do not measure on the map before it is placed.";
    case LimitKind::kNorthGuessed:
      return "Which way is north is a guess: the map may be turned.";
    case LimitKind::kFewPositions:
      return fmt::format(
          "Only {} of {} photos {} a position that places the map: it may lie, and be turned and scaled, "
          "otherwise.",
          count, of, count == 1 ? "has" : "have");
    case LimitKind::kPositionsContradicted:
      return "Recorded positions contradict what the photos show: the map may lie further off than they claim.";
    case LimitKind::kFarOff:
      return "The stated error is more than 10 m: the map may lie far from its true place.";
    case LimitKind::kControlContradicted:
      return "Surveyed points and the photos' own positions contradict each other: one of the two is far off.";
    case LimitKind::kChecksMissed:
      return fmt::format(
          "The map misses {} of {} by far more than the survey and what places it err by: one of the two is "
          "wrong there.",
          count, Counted(of, "check point"));
    case LimitKind::kPlacedByHand:
      return "The map was placed by hand: nothing tells how far off it lies.";
    case LimitKind::kLeftOut:
      return fmt::format("{} of {} photos {} left out: the map may have gaps there.", count, of,
                         count == 1 ? "was" : "were");
    case LimitKind::kNoneAligned:
      return "No photo could be aligned with another: they lie where they were recorded, with visible seams.";
    case LimitKind::kPoseOnly:
      return fmt::format("{} of {} photos {} only where recorded: expect visible seams there.", count, of,
                         count == 1 ? "lies" : "lie");
  }
  return {};
}

std::string QualityJson(const MapQuality& quality) {
  QualityDocument limits = QualityDocument::array();
  for (const MapLimit& limit : quality.limits)
    limits.push_back({{"kind", NameOf(limit.kind)}, {"count", limit.count}, {"of", limit.of}});
  const AbsoluteAccuracy& absolute = quality.absolute;
  const RelativeAccuracy& relative = quality.relative;
  QualityDocument json;
  json["status"] = NameOf(quality.status);
  json["absolute"] = {
      {"sigma_m", NumberOrNull(absolute.sigma_m)}, {"by", NameOf(absolute.by)}, {"count", absolute.count}};
  json["relative"] = {{"error_m", NumberOrNull(relative.error_m)},
                      {"error_px", NumberOrNull(relative.error_px)},
                      {"by", NameOf(relative.by)},
                      {"count", relative.count}};
  json["limits"] = limits;
  return JsonText(json);
}

Result<MapQuality> ParseQuality(std::string_view json) {
  try {
    return QualityOf(ParseOrderedJson(json));
  } catch (const QualityDocument::exception& broken) {
    return Error{ErrorCode::kCorrupt, "What is said of the map's quality is damaged.", broken.what()};
  }
}

}  // namespace skyquilt::pipeline
