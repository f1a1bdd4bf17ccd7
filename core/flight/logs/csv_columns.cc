#include "core/flight/logs/csv_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "core/flight/logs/csv_units.h"
#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

struct MeaningFacts {
  M meaning;
  std::string_view words;
  Dimension dimension;
};
constexpr std::array kFacts = {
    MeaningFacts{M::kIgnored, "ignored", Dimension::kNone},
    MeaningFacts{M::kTime, "time", Dimension::kTime},
    MeaningFacts{M::kUtc, "date and time", Dimension::kNone},
    MeaningFacts{M::kLat, "latitude", Dimension::kNone},
    MeaningFacts{M::kLon, "longitude", Dimension::kNone},
    MeaningFacts{M::kHeightEllipsoid, "height above the ellipsoid", Dimension::kLength},
    MeaningFacts{M::kHeightAmsl, "height above mean sea level", Dimension::kLength},
    MeaningFacts{M::kHeightAboveTakeoff, "height above take-off", Dimension::kLength},
    MeaningFacts{M::kHeightAboveGround, "height above ground", Dimension::kLength},
    MeaningFacts{M::kRange, "range to the ground", Dimension::kLength},
    MeaningFacts{M::kBaroHeight, "barometric height", Dimension::kLength},
    MeaningFacts{M::kPressure, "air pressure", Dimension::kPressure},
    MeaningFacts{M::kVelocityNorth, "velocity north", Dimension::kSpeed},
    MeaningFacts{M::kVelocityEast, "velocity east", Dimension::kSpeed},
    MeaningFacts{M::kVelocityDown, "velocity down", Dimension::kSpeed},
    MeaningFacts{M::kSigmaHorizontal, "horizontal sigma", Dimension::kLength},
    MeaningFacts{M::kSigmaVertical, "vertical sigma", Dimension::kLength},
    MeaningFacts{M::kFix, "kind of fix", Dimension::kNone},
    MeaningFacts{M::kGyroX, "angular rate x", Dimension::kRate},
    MeaningFacts{M::kGyroY, "angular rate y", Dimension::kRate},
    MeaningFacts{M::kGyroZ, "angular rate z", Dimension::kRate},
    MeaningFacts{M::kAccelX, "specific force x", Dimension::kAcceleration},
    MeaningFacts{M::kAccelY, "specific force y", Dimension::kAcceleration},
    MeaningFacts{M::kAccelZ, "specific force z", Dimension::kAcceleration},
    MeaningFacts{M::kQw, "attitude quaternion w", Dimension::kNone},
    MeaningFacts{M::kQx, "attitude quaternion x", Dimension::kNone},
    MeaningFacts{M::kQy, "attitude quaternion y", Dimension::kNone},
    MeaningFacts{M::kQz, "attitude quaternion z", Dimension::kNone},
    MeaningFacts{M::kRoll, "roll", Dimension::kAngle},
    MeaningFacts{M::kPitch, "pitch", Dimension::kAngle},
    MeaningFacts{M::kYaw, "yaw", Dimension::kAngle},
    MeaningFacts{M::kGimbalRoll, "gimbal roll", Dimension::kAngle},
    MeaningFacts{M::kGimbalPitch, "gimbal pitch", Dimension::kAngle},
    MeaningFacts{M::kGimbalYaw, "gimbal yaw", Dimension::kAngle},
    MeaningFacts{M::kSigmaTilt, "sigma of roll and pitch", Dimension::kAngle},
    MeaningFacts{M::kSigmaYaw, "sigma of yaw", Dimension::kAngle},
    MeaningFacts{M::kEvent, "camera event", Dimension::kNone},
    MeaningFacts{M::kIsPhoto, "photo taken in this row", Dimension::kNone},
    MeaningFacts{M::kImage, "image", Dimension::kNone}};
static_assert(kFacts.size() == static_cast<std::size_t>(M::kCount));

struct Name {
  std::string_view name;
  M meaning;
};

constexpr std::array kCanonicalFlight = {Name{"t", M::kTime},
                                         Name{"utc", M::kUtc},
                                         Name{"wx", M::kGyroX},
                                         Name{"wy", M::kGyroY},
                                         Name{"wz", M::kGyroZ},
                                         Name{"ax", M::kAccelX},
                                         Name{"ay", M::kAccelY},
                                         Name{"az", M::kAccelZ},
                                         Name{"qw", M::kQw},
                                         Name{"qx", M::kQx},
                                         Name{"qy", M::kQy},
                                         Name{"qz", M::kQz},
                                         Name{"roll", M::kRoll},
                                         Name{"pitch", M::kPitch},
                                         Name{"yaw", M::kYaw},
                                         Name{"lat", M::kLat},
                                         Name{"lon", M::kLon},
                                         Name{"alt_ell", M::kHeightEllipsoid},
                                         Name{"alt_msl", M::kHeightAmsl},
                                         Name{"vn", M::kVelocityNorth},
                                         Name{"ve", M::kVelocityEast},
                                         Name{"vd", M::kVelocityDown},
                                         Name{"sh", M::kSigmaHorizontal},
                                         Name{"sv", M::kSigmaVertical},
                                         Name{"fix", M::kFix},
                                         Name{"baro_alt", M::kBaroHeight},
                                         Name{"press", M::kPressure},
                                         Name{"range", M::kRange},
                                         Name{"rel_alt", M::kHeightAboveTakeoff},
                                         Name{"event", M::kEvent},
                                         Name{"image", M::kImage},
                                         Name{"s_rp", M::kSigmaTilt},
                                         Name{"s_yaw", M::kSigmaYaw}};

// Names without blanks, underscores and units, lower case.
constexpr std::array kSynonyms = {Name{"t", M::kTime},
                                  Name{"time", M::kTime},
                                  Name{"timestamp", M::kTime},
                                  Name{"elapsed", M::kTime},
                                  Name{"elapsedtime", M::kTime},
                                  Name{"flytime", M::kTime},
                                  Name{"offsettime", M::kTime},
                                  Name{"timeboot", M::kTime},
                                  Name{"utc", M::kUtc},
                                  Name{"datetime", M::kUtc},
                                  Name{"gpsdatetime", M::kUtc},
                                  Name{"utctime", M::kUtc},
                                  Name{"lat", M::kLat},
                                  Name{"latitude", M::kLat},
                                  Name{"gpslat", M::kLat},
                                  Name{"gpslatitude", M::kLat},
                                  Name{"osdlatitude", M::kLat},
                                  Name{"lon", M::kLon},
                                  Name{"lng", M::kLon},
                                  Name{"long", M::kLon},
                                  Name{"longitude", M::kLon},
                                  Name{"gpslon", M::kLon},
                                  Name{"gpslng", M::kLon},
                                  Name{"gpslongitude", M::kLon},
                                  Name{"longtitude", M::kLon},
                                  Name{"osdlongitude", M::kLon},
                                  Name{"altell", M::kHeightEllipsoid},
                                  Name{"ellipsoidalheight", M::kHeightEllipsoid},
                                  Name{"altitudewgs84", M::kHeightEllipsoid},
                                  Name{"altellipsoid", M::kHeightEllipsoid},
                                  Name{"altmsl", M::kHeightAmsl},
                                  Name{"alt", M::kHeightAmsl},
                                  Name{"altitude", M::kHeightAmsl},
                                  Name{"altitudeabovesealevel", M::kHeightAmsl},
                                  Name{"altitudemsl", M::kHeightAmsl},
                                  Name{"altitudeamsl", M::kHeightAmsl},
                                  Name{"gpsaltitude", M::kHeightAmsl},
                                  Name{"absolutealtitude", M::kHeightAmsl},
                                  Name{"absalt", M::kHeightAmsl},
                                  Name{"heightabovetakeoff", M::kHeightAboveTakeoff},
                                  Name{"relalt", M::kHeightAboveTakeoff},
                                  Name{"relativealtitude", M::kHeightAboveTakeoff},
                                  Name{"height", M::kHeightAboveTakeoff},
                                  Name{"osdheight", M::kHeightAboveTakeoff},
                                  Name{"relativeheight", M::kHeightAboveTakeoff},
                                  Name{"heightabovegroundatdronelocation", M::kHeightAboveGround},
                                  Name{"agl", M::kHeightAboveGround},
                                  Name{"heightaboveground", M::kHeightAboveGround},
                                  Name{"range", M::kRange},
                                  Name{"rangefinder", M::kRange},
                                  Name{"heightsonar", M::kRange},
                                  Name{"sonar", M::kRange},
                                  Name{"distancesensor", M::kRange},
                                  Name{"lidar", M::kRange},
                                  Name{"ultrasonic", M::kRange},
                                  Name{"baroalt", M::kBaroHeight},
                                  Name{"baroheight", M::kBaroHeight},
                                  Name{"barometricaltitude", M::kBaroHeight},
                                  Name{"baroaltitude", M::kBaroHeight},
                                  Name{"barometer", M::kBaroHeight},
                                  Name{"press", M::kPressure},
                                  Name{"pressure", M::kPressure},
                                  Name{"airpressure", M::kPressure},
                                  Name{"baro", M::kPressure},
                                  Name{"vn", M::kVelocityNorth},
                                  Name{"velocitynorth", M::kVelocityNorth},
                                  Name{"veln", M::kVelocityNorth},
                                  Name{"xspeed", M::kVelocityNorth},
                                  Name{"vnorth", M::kVelocityNorth},
                                  Name{"osdxspeed", M::kVelocityNorth},
                                  Name{"ve", M::kVelocityEast},
                                  Name{"velocityeast", M::kVelocityEast},
                                  Name{"vele", M::kVelocityEast},
                                  Name{"yspeed", M::kVelocityEast},
                                  Name{"veast", M::kVelocityEast},
                                  Name{"osdyspeed", M::kVelocityEast},
                                  Name{"vd", M::kVelocityDown},
                                  Name{"velocitydown", M::kVelocityDown},
                                  Name{"veld", M::kVelocityDown},
                                  Name{"zspeed", M::kVelocityDown},
                                  Name{"vdown", M::kVelocityDown},
                                  Name{"osdzspeed", M::kVelocityDown},
                                  Name{"sh", M::kSigmaHorizontal},
                                  Name{"hacc", M::kSigmaHorizontal},
                                  Name{"horizontalaccuracy", M::kSigmaHorizontal},
                                  Name{"eph", M::kSigmaHorizontal},
                                  Name{"sv", M::kSigmaVertical},
                                  Name{"vacc", M::kSigmaVertical},
                                  Name{"verticalaccuracy", M::kSigmaVertical},
                                  Name{"epv", M::kSigmaVertical},
                                  Name{"fix", M::kFix},
                                  Name{"fixtype", M::kFix},
                                  Name{"gpsfix", M::kFix},
                                  Name{"wx", M::kGyroX},
                                  Name{"gx", M::kGyroX},
                                  Name{"gyrox", M::kGyroX},
                                  Name{"gyrx", M::kGyroX},
                                  Name{"xgyro", M::kGyroX},
                                  Name{"angularvelocityx", M::kGyroX},
                                  Name{"gyroscopex", M::kGyroX},
                                  Name{"omegax", M::kGyroX},
                                  Name{"wy", M::kGyroY},
                                  Name{"gy", M::kGyroY},
                                  Name{"gyroy", M::kGyroY},
                                  Name{"gyry", M::kGyroY},
                                  Name{"ygyro", M::kGyroY},
                                  Name{"angularvelocityy", M::kGyroY},
                                  Name{"gyroscopey", M::kGyroY},
                                  Name{"omegay", M::kGyroY},
                                  Name{"wz", M::kGyroZ},
                                  Name{"gz", M::kGyroZ},
                                  Name{"gyroz", M::kGyroZ},
                                  Name{"gyrz", M::kGyroZ},
                                  Name{"zgyro", M::kGyroZ},
                                  Name{"angularvelocityz", M::kGyroZ},
                                  Name{"gyroscopez", M::kGyroZ},
                                  Name{"omegaz", M::kGyroZ},
                                  Name{"ax", M::kAccelX},
                                  Name{"accx", M::kAccelX},
                                  Name{"accelx", M::kAccelX},
                                  Name{"xacc", M::kAccelX},
                                  Name{"accelerometerx", M::kAccelX},
                                  Name{"accelerationx", M::kAccelX},
                                  Name{"linearaccelerationx", M::kAccelX},
                                  Name{"ay", M::kAccelY},
                                  Name{"accy", M::kAccelY},
                                  Name{"accely", M::kAccelY},
                                  Name{"yacc", M::kAccelY},
                                  Name{"accelerometery", M::kAccelY},
                                  Name{"accelerationy", M::kAccelY},
                                  Name{"linearaccelerationy", M::kAccelY},
                                  Name{"az", M::kAccelZ},
                                  Name{"accz", M::kAccelZ},
                                  Name{"accelz", M::kAccelZ},
                                  Name{"zacc", M::kAccelZ},
                                  Name{"accelerometerz", M::kAccelZ},
                                  Name{"accelerationz", M::kAccelZ},
                                  Name{"linearaccelerationz", M::kAccelZ},
                                  Name{"qw", M::kQw},
                                  Name{"q0", M::kQw},
                                  Name{"qx", M::kQx},
                                  Name{"q1", M::kQx},
                                  Name{"qy", M::kQy},
                                  Name{"q2", M::kQy},
                                  Name{"qz", M::kQz},
                                  Name{"q3", M::kQz},
                                  Name{"roll", M::kRoll},
                                  Name{"osdroll", M::kRoll},
                                  Name{"pitch", M::kPitch},
                                  Name{"osdpitch", M::kPitch},
                                  Name{"yaw", M::kYaw},
                                  Name{"heading", M::kYaw},
                                  Name{"compassheading", M::kYaw},
                                  Name{"osdyaw", M::kYaw},
                                  Name{"gimbalroll", M::kGimbalRoll},
                                  Name{"gimbalpitch", M::kGimbalPitch},
                                  Name{"gimbalheading", M::kGimbalYaw},
                                  Name{"gimbalyaw", M::kGimbalYaw},
                                  Name{"event", M::kEvent},
                                  Name{"cameratrigger", M::kEvent},
                                  Name{"isphoto", M::kIsPhoto},
                                  Name{"photo", M::kIsPhoto},
                                  Name{"cameraisphoto", M::kIsPhoto},
                                  Name{"image", M::kImage},
                                  Name{"imagename", M::kImage},
                                  Name{"filename", M::kImage},
                                  Name{"file", M::kImage}};

const MeaningFacts& FactsOf(M meaning) { return kFacts[static_cast<std::size_t>(meaning)]; }

std::string Letters(std::string_view text) {
  std::string letters;
  for (const char c : text) {
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) letters += c;
  }
  return letters;
}

M FindSynonym(std::string_view letters) {
  for (const Name& name : kSynonyms) {
    if (name.name == letters) return name.meaning;
  }
  return M::kIgnored;
}

// "acc_x [m/s^2]" -> "acc_x ", "m/s^2".
std::pair<std::string, std::string> CutBrackets(const std::string& lower) {
  const std::size_t open = lower.find_first_of("([");
  if (open == std::string::npos) return {lower, ""};
  const std::size_t close = lower.find_first_of(")]", open);
  const std::string inside = lower.substr(open + 1, close == std::string::npos ? close : close - open - 1);
  return {lower.substr(0, open), std::string(Trim(inside))};
}

CsvColumn MapTolerantColumn(std::string_view header) {
  CsvColumn column;
  column.header = Trim(header);
  const std::string lower = LowerCase(column.header);
  auto [base, unit] = CutBrackets(lower);
  column.says_utc = lower.find("utc") != std::string::npos || lower.find("gmt") != std::string::npos;
  column.meaning = FindSynonym(Letters(base));
  if (column.meaning == M::kIgnored && unit.empty()) {
    // The last word may be the unit: "gyro_x_dps".
    const std::size_t cut = base.find_last_of("_ .");
    if (cut != std::string::npos) {
      const M meaning = FindSynonym(Letters(base.substr(0, cut)));
      const std::string word = base.substr(cut + 1);
      if (meaning != M::kIgnored && FindUnit(word, FactsOf(meaning).dimension) != nullptr) {
        column.meaning = meaning;
        unit = word;
      }
    }
  }
  const Dimension dimension = FactsOf(column.meaning).dimension;
  const auto [scale, name] = DefaultUnit(dimension);
  column.scale = scale;
  column.unit = name;
  if (dimension == Dimension::kNone || unit.empty()) return column;
  if (const CsvUnit* known = FindUnit(unit, dimension)) {
    column.scale = known->factor;
    column.unit = known->name;
    column.unit_is_written = true;
  } else {
    column.meaning = M::kIgnored;  // "Time(text)": not a unit of this
  }
  return column;
}

template <std::size_t N>
M FindExact(const std::array<Name, N>& names, std::string_view header) {
  for (const Name& name : names) {
    if (name.name == header) return name.meaning;
  }
  return M::kIgnored;
}

void DropRepeated(std::vector<CsvColumn>& columns) {
  std::array<bool, static_cast<std::size_t>(M::kCount)> seen{};
  for (CsvColumn& column : columns) {
    bool& taken = seen[static_cast<std::size_t>(column.meaning)];
    if (taken) column.meaning = M::kIgnored;
    taken = true;
  }
}

bool Has(const std::vector<std::string_view>& header, std::string_view name) {
  return std::find(header.begin(), header.end(), name) != header.end();
}

bool AllCanonical(const std::vector<std::string_view>& header) {
  return header.size() >= 2 && std::all_of(header.begin(), header.end(), [](std::string_view name) {
           return FindExact(kCanonicalFlight, name) != M::kIgnored;
         });
}

}  // namespace

std::vector<CsvColumn> MapCanonicalColumns(const std::vector<std::string_view>& header) {
  std::vector<CsvColumn> columns;
  for (const std::string_view name : header) {
    CsvColumn column;
    column.header = name;
    column.meaning = FindExact(kCanonicalFlight, name);
    const auto [scale, unit] = DefaultUnit(FactsOf(column.meaning).dimension);
    column.scale = scale;
    column.unit = unit;
    column.unit_is_written = true;  // the format fixes it
    column.says_utc = column.meaning == M::kUtc;
    columns.push_back(std::move(column));
  }
  DropRepeated(columns);
  return columns;
}

bool IsCanonicalFlightHeader(const std::vector<std::string_view>& header) {
  return AllCanonical(header) && (Has(header, "t") || Has(header, "utc")) && !Has(header, "image");
}

bool IsCanonicalImagesHeader(const std::vector<std::string_view>& header) {
  return AllCanonical(header) && Has(header, "image");
}

std::vector<CsvColumn> MapTolerantColumns(const std::vector<std::string_view>& header) {
  std::vector<CsvColumn> columns;
  for (const std::string_view name : header) columns.push_back(MapTolerantColumn(name));
  DropRepeated(columns);
  return columns;
}

std::vector<std::string> DescribeColumns(const std::vector<CsvColumn>& columns) {
  std::vector<std::string> lines;
  for (const CsvColumn& column : columns) {
    if (column.meaning == M::kIgnored) continue;
    std::string line = fmt::format("{} -> {}", column.header.substr(0, 80), CsvMeaningName(column.meaning));
    if (!column.unit.empty()) line += fmt::format(", {}", column.unit);
    if (!column.unit.empty() && !column.unit_is_written) line += " (assumed)";
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string_view CsvMeaningName(CsvMeaning meaning) { return FactsOf(meaning).words; }

}  // namespace skyquilt::flight
