#include "core/flight/metadata/position_tags.h"

#include <cctype>
#include <cmath>
#include <string_view>

#include "core/flight/bytes/text_fields.h"
#include "core/geo/geodesic.h"

namespace skyquilt::flight {
namespace {

constexpr double kLowestM = -500.0;
constexpr double kHighestM = 10000.0;

std::optional<double> Height(const XmpTags& xmp, std::string_view name) {
  const auto value = xmp.Number(name);
  if (!value || *value < kLowestM || *value > kHighestM) return std::nullopt;
  return value;
}

std::optional<double> Sigma(const XmpTags& xmp, std::string_view name) {
  const auto value = xmp.Number(name);
  if (!value || *value <= 0.0 || *value > 1000.0) return std::nullopt;
  return value;
}

// "46,50.5566N" or "46,50,33.4N", the form of XMP's own exif:GPSLatitude.
std::optional<double> ParseXmpExifAngle(std::string text) {
  if (text.size() < 2) return std::nullopt;
  const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(text.back())));
  text.pop_back();
  const double sign = letter == 'S' || letter == 'W' ? -1.0 : 1.0;
  if (std::string_view("NSEW").find(letter) == std::string_view::npos) return std::nullopt;
  double degrees = 0.0;
  double unit = 1.0;
  for (int part = 0; part < 3 && !text.empty(); ++part, unit /= 60.0) {
    const std::size_t comma = text.find(',');
    const auto number = ParseXmpNumber(text.substr(0, comma));
    if (!number || *number < 0.0) return std::nullopt;
    // Programs copy those of EXIF whose point was lost.
    if (degrees > 0.0 && *number > 60.0) return std::nullopt;
    degrees += *number * unit;
    text = comma == std::string::npos ? "" : text.substr(comma + 1);
  }
  return sign * degrees;
}

std::optional<geo::LatLon> Position(std::optional<double> lat_deg, std::optional<double> lon_deg) {
  if (!lat_deg || !lon_deg) return std::nullopt;
  if (std::abs(*lat_deg) < 1e-6 && std::abs(*lon_deg) < 1e-6) return std::nullopt;  // no fix
  const auto position = geo::LatLon::Make(*lat_deg, *lon_deg);
  if (!position) return std::nullopt;
  return *position;
}

// As the maker writes it, in XMP of its own.
std::optional<geo::LatLon> MakersPosition(const XmpTags& xmp) {
  constexpr std::pair<std::string_view, std::string_view> kPairs[] = {
      {"drone-dji:GpsLatitude", "drone-dji:GpsLongitude"},
      {"drone-dji:GpsLatitude", "drone-dji:GpsLongtitude"},  // the maker's spelling
      {"drone-dji:Latitude", "drone-dji:Longitude"},
      {"drone-skydio:Latitude", "drone-skydio:Longitude"},
      {"sensefly:Latitude", "sensefly:Longitude"}};
  for (const auto& [lat, lon] : kPairs) {
    if (const auto position = Position(xmp.Number(lat), xmp.Number(lon))) return position;
  }
  return std::nullopt;
}

std::optional<geo::LatLon> XmpPosition(const XmpTags& xmp) {
  if (const auto position = MakersPosition(xmp)) return position;
  return Position(ParseXmpExifAngle(xmp.Text("exif:GPSLatitude")),
                  ParseXmpExifAngle(xmp.Text("exif:GPSLongitude")));
}

std::optional<RecordedPosition> ChoosePosition(const ExifRecord& exif, const XmpTags& xmp,
                                               std::vector<Remark>& notes) {
  const auto from_xmp = XmpPosition(xmp);
  RecordedPosition recorded;
  if (!exif.position) {
    if (!from_xmp) return std::nullopt;
    recorded.position = *from_xmp;
    recorded.source = "xmp";
    return recorded;
  }
  recorded.position = *exif.position;
  recorded.source = "exif";
  if (!from_xmp) {
    if (!exif.is_hemisphere_known) {
      notes.push_back(RemarkCode::kHemispheresUnsaid);
    }
    return recorded;
  }
  const double apart_m = geo::MetresApart(*exif.position, *from_xmp);
  constexpr double kFineStepM = 0.02;
  constexpr double kFarApartM = 50.0;
  if (!exif.is_hemisphere_known ||
      (exif.position_resolution_m > kFineStepM && apart_m < 2.0 * exif.position_resolution_m)) {
    recorded.position = *from_xmp;
    recorded.source = "xmp";
  } else if (apart_m > kFarApartM) {
    notes.push_back({RemarkCode::kPositionsApart, {{"apart_m", apart_m}}});
  }
  return recorded;
}

std::optional<double> MakersAltitude(const XmpTags& xmp) {
  const auto altitude_m = Height(xmp, "drone-dji:AbsoluteAltitude");
  return altitude_m ? altitude_m : Height(xmp, "drone-skydio:AbsoluteAltitude");
}

// XMP's own exif:GPSAltitude, as files beside photos have it.
std::optional<double> XmpExifAltitude(const XmpTags& xmp) {
  const auto altitude_m = Height(xmp, "exif:GPSAltitude");
  const auto reference = xmp.Number("exif:GPSAltitudeRef");
  const bool is_below = reference == 1.0 || reference == 3.0;
  return altitude_m && is_below ? -std::abs(*altitude_m) : altitude_m;
}

// By what the photo says of it, else by what the makers say of their aircraft.
bool IsAbsoluteAltitudeEllipsoidal(const ExifRecord& exif, const XmpTags& xmp) {
  const std::string kind = xmp.Text("drone-dji:AltitudeType");
  // Some without a receiver of RTK (Mini 3 Pro) write it beside heights above the sea.
  const bool knows_rtk =
      xmp.Find("drone-dji:RtkFlag") != nullptr || xmp.Find("drone-dji:RtkStdHgt") != nullptr;
  if (!kind.empty()) return kind == "RtkAlt" && knows_rtk;
  if (xmp.Number("drone-dji:RtkFlag").value_or(0.0) > 0.0) return true;
  const std::string make = LowerCase(exif.make);
  // Autel's older firmware wrote "ellipsoidal" beside heights above the sea.
  std::string zero = LowerCase(xmp.Text("Camera:VertCS"));
  if (zero.empty()) zero = LowerCase(xmp.Text("drone-skydio:VertCS"));
  if (!zero.empty() && make.find("autel") == std::string::npos)
    return zero.starts_with("ellips") || zero == "epsg:4979";
  // Of the X10 the EXIF altitude; drone-skydio:AbsoluteAltitude is above the sea.
  const bool is_x10 = exif.model.starts_with("VT300") || exif.model.starts_with("V100");
  if (make == "skydio" && is_x10) return xmp.Find("drone-skydio:AbsoluteAltitude") == nullptr;
  return make == "sensefly" || HoldsOneOf(exif.model, {"ANAFI Ai", "AnafiAi"});
}

void ChooseHeights(const ExifRecord& exif, const XmpTags& xmp, RecordedPosition& recorded,
                   std::vector<Remark>& notes) {
  recorded.height_above_takeoff_m = HeightAboveTakeoffFromTags(xmp);
  if (const auto above_ground = Height(xmp, "Camera:AboveGroundAltitude");
      above_ground && *above_ground > 0.0) {
    recorded.height_above_ground_m = above_ground;
  }
  recorded.height_amsl_m = Height(xmp, "sensefly:AltitudeAMSL");
  recorded.height_ellipsoid_m = Height(xmp, "sensefly:AltitudeWGS84");
  if (recorded.height_amsl_m || recorded.height_ellipsoid_m) return;

  auto absolute = MakersAltitude(xmp);
  const bool is_ellipsoidal = IsAbsoluteAltitudeEllipsoidal(exif, xmp);
  const auto& relative = recorded.height_above_takeoff_m;
  constexpr double kSameM = 0.6;
  constexpr double kContradictionM = 50.0;
  if (absolute) {
    if (exif.altitude_m && relative && std::abs(*exif.altitude_m - *relative) < kSameM &&
        std::abs(*absolute - *relative) > 5.0) {
      notes.push_back(RemarkCode::kAltitudeOfTakeoff);
    } else if (exif.altitude_m && std::abs(*exif.altitude_m - *absolute) > kContradictionM) {
      notes.push_back({RemarkCode::kAltitudesApart, {{"exif_m", *exif.altitude_m}, {"xmp_m", *absolute}}});
    }
  } else if (exif.altitude_m) {
    if (relative && std::abs(*exif.altitude_m - *relative) < kSameM) {
      notes.push_back(RemarkCode::kAltitudeRepeatsHeight);
    } else {
      absolute = exif.altitude_m;
    }
  } else {
    absolute = XmpExifAltitude(xmp);
  }
  (is_ellipsoidal ? recorded.height_ellipsoid_m : recorded.height_amsl_m) = absolute;
  // Named by what it counts from, whatever AbsoluteAltitude beside it does.
  if (const auto above_sea = Height(xmp, "drone-skydio:GpsMslHeight"); above_sea && *above_sea != 0.0)
    recorded.height_amsl_m = above_sea;
}

void ChooseSigmas(const ExifRecord& exif, const XmpTags& xmp, RecordedPosition& recorded) {
  constexpr double kRtkFixed = 50.0;  // 16: single point, 34: float
  recorded.is_rtk_fixed = xmp.Number("drone-dji:RtkFlag") == kRtkFixed;
  const auto std_lon = Sigma(xmp, "drone-dji:RtkStdLon");
  const auto std_lat = Sigma(xmp, "drone-dji:RtkStdLat");
  if (std_lon && std_lat) recorded.sigma_horizontal_m = std::hypot(*std_lon, *std_lat) / std::sqrt(2.0);
  recorded.sigma_vertical_m = Sigma(xmp, "drone-dji:RtkStdHgt");
  for (const std::string_view name : {"Camera:GPSXYAccuracy", "drone-skydio:GpsHorizontalAccuracy"}) {
    if (!recorded.sigma_horizontal_m) recorded.sigma_horizontal_m = Sigma(xmp, name);
  }
  for (const std::string_view name : {"Camera:GPSZAccuracy", "drone-skydio:GpsVerticalAccuracy"}) {
    if (!recorded.sigma_vertical_m) recorded.sigma_vertical_m = Sigma(xmp, name);
  }
  if (!recorded.sigma_horizontal_m) recorded.sigma_horizontal_m = exif.position_error_m;
  constexpr double kOtherDatumM = 300.0;  // between older datums, and maps shifted by law, and WGS 84
  if (recorded.source == "exif" && exif.is_beside_wgs84) recorded.system_error_m = kOtherDatumM;
  // Written in whole seconds, say: what is lost of a step is spread evenly over it.
  constexpr double kCoarseStepM = 1.0;
  if (recorded.source == "exif" && exif.position_resolution_m > kCoarseStepM) {
    recorded.sigma_horizontal_m = std::hypot(recorded.sigma_horizontal_m.value_or(kPlainSigmaM),
                                             exif.position_resolution_m / std::sqrt(12.0));
  }
}

}  // namespace

std::optional<double> HeightAboveTakeoffFromTags(const XmpTags& xmp) {
  for (const std::string_view name :
       {"drone-dji:RelativeAltitude", "drone-skydio:RelativeAltitude", "drone-yuneec:AboveHomeAltitude",
        "sensefly:Height", "aerialgps:GPSAltitudeAboveTakeOff"}) {
    if (const auto height_m = Height(xmp, name)) return height_m;
  }
  // Other programs mean another altitude by that name.
  return xmp.Find("xmp:CameraPitch") != nullptr ? Height(xmp, "xmp:GPSAltitude") : std::nullopt;
}

std::optional<RecordedPosition> PositionFromTags(const ExifRecord& exif, const XmpTags& xmp,
                                                 std::vector<Remark>& notes) {
  std::optional<RecordedPosition> recorded = ChoosePosition(exif, xmp, notes);
  if (!recorded) return std::nullopt;
  ChooseHeights(exif, xmp, *recorded, notes);
  ChooseSigmas(exif, xmp, *recorded);
  return recorded;
}

std::optional<ExifBesideXmp> ExifBesideXmpFromTags(const ExifRecord& exif, const XmpTags& xmp) {
  const auto makers_place = MakersPosition(xmp);
  const auto makers_altitude_m = MakersAltitude(xmp);
  if (!makers_place || !makers_altitude_m || !exif.position || !exif.is_hemisphere_known) return std::nullopt;
  if (!exif.altitude_m || *exif.altitude_m == 0.0) return std::nullopt;
  return ExifBesideXmp{*exif.position,   *makers_place,      exif.position_resolution_m,
                       *exif.altitude_m, *makers_altitude_m, exif.is_altitude_from_sea};
}

}  // namespace skyquilt::flight
