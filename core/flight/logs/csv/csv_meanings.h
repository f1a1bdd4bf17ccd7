// What a column of a CSV log can mean, and the names that programs give it. Pure functions; any thread.
#pragma once

#include <string_view>

#include "core/flight/logs/csv/csv_units.h"

namespace skyquilt::flight {

enum class CsvMeaning {
  kIgnored,
  kTime,  // s
  kUtc,   // text, or local time where the header does not say UTC
  kDate,
  kTimeOfDay,  // the two halves of kUtc
  kLat,
  kLon,  // deg
  kLatLetter,
  kLonLetter,  // "N" or "South", where it stands in a column of its own
  kHeightEllipsoid,
  kHeightAmsl,
  kHeightAboveTakeoff,
  kHeightAboveGround,
  kRange,
  kBaroHeight,  // m
  kPressure,    // Pa
  kVelocityNorth,
  kVelocityEast,
  kVelocityDown,  // m/s
  kSigmaHorizontal,
  kSigmaVertical,  // m
  kFix,
  kGyroX,
  kGyroY,
  kGyroZ,  // rad/s
  kAccelX,
  kAccelY,
  kAccelZ,  // m/s2
  kQw,
  kQx,
  kQy,
  kQz,
  kRoll,
  kPitch,
  kYaw,  // rad
  kGimbalRoll,
  kGimbalPitch,
  kGimbalYaw,  // rad
  kSigmaTilt,
  kSigmaYaw,  // rad
  kEvent,     // image name or number
  kIsPhoto,   // 1 in the row of an exposure, or the photo's name
  kImage,     // name
  // Of lists of photos alone (list_columns.h):
  kEast,
  kNorth,  // in the unit of the list's system
  kOmega,
  kPhi,
  kKappa,  // rad
  kCount
};
inline bool IsHeight(CsvMeaning m) {
  return m >= CsvMeaning::kHeightEllipsoid && m <= CsvMeaning::kHeightAboveGround;
}
inline bool IsOfClock(CsvMeaning m) { return m >= CsvMeaning::kUtc && m <= CsvMeaning::kTimeOfDay; }

// In words, for the user.
std::string_view CsvMeaningName(CsvMeaning meaning);
Dimension CsvMeaningDimension(CsvMeaning meaning);

// By one of the names that other programs use, lower case, without blanks, underscores and units.
CsvMeaning FindCsvSynonym(std::string_view letters);

// Which of two coordinates is the east one, by their names.
enum class PairOrder {
  kNamed,
  kXThenY,  // "x", "y": longitude and latitude in degrees; surveyors' x may be north
  kOpen,    // "coordinate1", "coordinate2"
};
// Of marks that surveyed points have in photos.
enum class MarkPart { kNone, kPixel, kPoint };

// Columns of lists beside those that logs have: coordinates in a plane, angles, marks.
struct ListName {
  std::string_view names;
  CsvMeaning meaning = CsvMeaning::kIgnored;  // of a photo's own
  PairOrder order = PairOrder::kNamed;
  MarkPart mark = MarkPart::kNone;
};
// By the same letters, null for others; a letter alone ("E") must be the whole name.
const ListName* FindListName(std::string_view letters);

}  // namespace skyquilt::flight
