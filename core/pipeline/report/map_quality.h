// MapQuality: how true a map is and whether it is fit for use, as every surface says it: report.json, command
// line, report page, API, STAC and page. Judged in judge_map.h alone; here are its words and its JSON. A
// number that nothing supports is absent. Values; any thread. Errors of parsing: kCorrupt.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::pipeline {

enum class AbsoluteSupport : std::uint8_t {
  kNone,           // no position places it
  kHand,           // somebody said where it lies; with a number, reckoned by a log from there
  kGnss,           // photos' positions or a log's, of a receiver without corrections
  kRtk,            // corrected ones (RTK, PPK)
  kControlPoints,  // surveyed points that place it
  kCheckPoints,    // surveyed points that do not
};

// Where the map lies on Earth.
struct AbsoluteAccuracy {
  // Horizontal: within this radius lie 68.3 % of the map's places, as within one standard deviation of one
  // number. Two significant digits.
  std::optional<double> sigma_m;
  AbsoluteSupport by = AbsoluteSupport::kNone;
  int count = 0;  // positions or points

  bool operator==(const AbsoluteAccuracy&) const = default;
};

enum class RelativeSupport : std::uint8_t {
  kNone,
  kTiePoints,  // root mean square of what photos miss shared points by
  kSeams,      // median of what neighbouring photos show apart along seams
};

// How well the map fits itself, wherever it lies. Two significant digits.
struct RelativeAccuracy {
  std::optional<double> error_m;  // absent where the map's scale is a guess
  std::optional<double> error_px;
  RelativeSupport by = RelativeSupport::kNone;
  int count = 0;

  bool operator==(const RelativeAccuracy&) const = default;
};

enum class MapStatus : std::uint8_t {
  kReady,
  kLimited,   // of use, but for its limits
  kDoubtful,  // so little places it that nobody should rely on where it lies
  kUnplaced,  // nothing says where on Earth it lies
  kUnknown,   // imported without a word on it
};

enum class LimitKind : std::uint8_t {
  kNotGeoreferenced,
  kScaleGuessed,           // lengths, areas and the resolution mean nothing
  kNorthGuessed,           // directions mean nothing
  kFewPositions,           // `count` of `of` photos place it
  kPositionsContradicted,  // by what the photos show: most, many, or several by one shift
  kFarOff,                 // its accuracy is worse than any receiver's
  kControlContradicted,    // surveyed points place it far from where its photos say they were taken
  kChecksMissed,           // `count` of `of` check points, by far more than both sides err by
  kPlacedByHand,
  kLeftOut,      // `count` of `of` photos; what leaves no gap (flight::LeavesNoGap) is none of them
  kNoneAligned,  // `count` photos lie by their records, none of them compared with success
  kPoseOnly,     // `count` of `of` photos lie by their records
};

struct MapLimit {
  LimitKind kind = LimitKind::kNotGeoreferenced;
  int count = 0;
  int of = 0;

  bool operator==(const MapLimit&) const = default;
};

struct MapQuality {
  MapStatus status = MapStatus::kUnplaced;
  AbsoluteAccuracy absolute;
  RelativeAccuracy relative;
  std::vector<MapLimit> limits;  // the weightiest first

  bool IsLimitedBy(LimitKind kind) const;
  bool operator==(const MapQuality&) const = default;
};

// Their names in JSON.
inline constexpr std::pair<AbsoluteSupport, std::string_view> kAbsoluteSupports[] = {
    {AbsoluteSupport::kNone, "none"},
    {AbsoluteSupport::kHand, "hand"},
    {AbsoluteSupport::kGnss, "gnss"},
    {AbsoluteSupport::kRtk, "rtk"},
    {AbsoluteSupport::kControlPoints, "control_points"},
    {AbsoluteSupport::kCheckPoints, "check_points"}};
inline constexpr std::pair<RelativeSupport, std::string_view> kRelativeSupports[] = {
    {RelativeSupport::kNone, "none"},
    {RelativeSupport::kTiePoints, "tie_points"},
    {RelativeSupport::kSeams, "seams"}};
inline constexpr std::pair<MapStatus, std::string_view> kMapStatuses[] = {{MapStatus::kReady, "ready"},
                                                                          {MapStatus::kLimited, "limited"},
                                                                          {MapStatus::kDoubtful, "doubtful"},
                                                                          {MapStatus::kUnplaced, "unplaced"},
                                                                          {MapStatus::kUnknown, "unknown"}};
inline constexpr std::pair<LimitKind, std::string_view> kLimitKinds[] = {
    {LimitKind::kNotGeoreferenced, "not_georeferenced"},
    {LimitKind::kScaleGuessed, "scale_guessed"},
    {LimitKind::kNorthGuessed, "north_guessed"},
    {LimitKind::kFewPositions, "few_positions"},
    {LimitKind::kPositionsContradicted, "positions_contradicted"},
    {LimitKind::kFarOff, "far_off"},
    {LimitKind::kControlContradicted, "control_contradicted"},
    {LimitKind::kChecksMissed, "checks_missed"},
    {LimitKind::kPlacedByHand, "placed_by_hand"},
    {LimitKind::kLeftOut, "left_out"},
    {LimitKind::kNoneAligned, "none_aligned"},
    {LimitKind::kPoseOnly, "pose_only"}};
std::string_view NameOf(AbsoluteSupport support);
std::string_view NameOf(RelativeSupport support);
std::string_view NameOf(MapStatus status);
std::string_view NameOf(LimitKind kind);

// The nearest number of two significant digits; what is not finite or not above zero is 0.
double OfTwoDigits(double value);

// "2.3 m", "3.4 cm". The page's formatError writes the same digits (tests/web/support/accuracy_texts.json).
std::string AccuracyText(double metres);

// "+-2.3 m (1 sigma), by 42 positions of GNSS"; "unknown: no positions".
std::string AbsoluteInWords(const MapQuality& quality);
// "1.2 cm (0.4 px), at 31 places along seams"; "unknown: no photos are tied to each other".
std::string RelativeInWords(const MapQuality& quality);
// "Ready to use", "Usable, with limits", "Place in doubt", "Not georeferenced", "Accuracy not known".
std::string_view StatusInWords(MapStatus status);
// "Ready to use. Absolute accuracy: +-2.3 m (1 sigma), ... Relative: 1.2 cm (0.4 px), ..."
std::string QualityInWords(const MapQuality& quality);
// A sentence.
std::string LimitInWords(const MapLimit& limit);

// One line, as report.json has it under "quality".
std::string QualityJson(const MapQuality& quality);
// Refuses numbers that no map can have, for texts of processes that are not trusted.
Result<MapQuality> ParseQuality(std::string_view json);

}  // namespace skyquilt::pipeline
