#include "core/flight/logs/csv/csv_meanings.h"

#include <cstddef>
#include <iterator>
#include <unordered_map>
#include <vector>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

// Names without blanks, underscores, units and letters beyond a to z, lower case, apart by blanks; English,
// and the common words of German, French and Spanish (Höhe is "hhe" here).
struct MeaningFacts {
  M meaning;
  std::string_view words;
  Dimension dimension;
  std::string_view names = {};
};
constexpr MeaningFacts kFacts[] = {
    {M::kIgnored, "ignored", Dimension::kNone},
    {M::kTime, "time", Dimension::kTime,
     "t time timestamp elapsed elapsedtime flytime offsettime timeboot osdflytime timeoffset "
     "elapsedseconds zeit tiempo"},
    {M::kUtc, "date and time", Dimension::kNone,
     "utc datetime gpsdatetime utctime datetimeoriginal createdate gpsdatetimeutc dateandtime datetimeutc "
     "captured capturetime capturedat datetaken phototime timeutc gpstimestamp zeitstempel datumuhrzeit "
     "datumzeit fechahora fechayhora dateheure horodatage customdatetime gpst timegpst datetimegpst"},
    {M::kDate, "date", Dimension::kNone,
     "date datum fecha customdate gpsdate gpsdatestamp dateutc localdate dateofflight"},
    {M::kTimeOfDay, "time of day", Dimension::kNone, "timeofday uhrzeit hora heure customupdatetime"},
    {M::kLat, "latitude", Dimension::kCoordinate,
     "lat latitude gpslat gpslatitude osdlatitude latitudens latitudedms latitudedd latitudedeg latwgs84 "
     "ylatitude latitudey breite breitengrad geographischebreite latitud exifgpslatitude xmpgpslatitude "
     "compositegpslatitude dronelatitude"},
    {M::kLon, "longitude", Dimension::kCoordinate,
     "lon lng long longitude gpslon gpslng gpslongitude longtitude osdlongitude longitudeew longitudedms "
     "longitudedd lonwgs84 xlongitude longitudex lnge laenge lngengrad laengengrad geographischelnge "
     "geographischelaenge longitud exifgpslongitude xmpgpslongitude compositegpslongitude dronelongitude"},
    {M::kLatLetter, "north or south", Dimension::kNone,
     "latituderef gpslatituderef latref ns latituden latitudedirection"},
    {M::kLonLetter, "east or west", Dimension::kNone,
     "longituderef gpslongituderef lonref ew longitudedirection"},
    {M::kHeightEllipsoid, "height above the ellipsoid", Dimension::kLength,
     "altell ellipsoidalheight altitudewgs84 altellipsoid ellipsoidheight heightellipsoid "
     "heightellipsoidal ellipsoidischehhe ellipsoidischehoehe ellipsoidhhe hauteurellipsodale "
     "hauteurellipsoidale alturaelipsoidal hae altitudeellipsoidal altitudeellipsoid ellht ellheight "
     "ellipht elliphgt ellipheight ellipsoidht ellipsoidalht wgs84height"},
    {M::kHeightAmsl, "height above mean sea level", Dimension::kLength,
     "altmsl alt altitude altitudeabovesealevel altitudemsl altitudeamsl gpsaltitude absolutealtitude "
     "absalt osdaltitude zaltitude mslaltitude amsl altitudeabovemeansealevel hhe hoehe meereshhe "
     "meereshoehe hhenn altitud elevation elev elevacin elevacion cota orthometricheight exifgpsaltitude "
     "compositegpsaltitude mslheight orthoht orthohgt orthoheight orthometricht"},
    {M::kHeightAboveTakeoff, "height above take-off", Dimension::kLength,
     "heightabovetakeoff relalt relativealtitude height osdheight relativeheight relativealt "
     "altituderelative heightrelative relativehhe hauteur altura"},
    {M::kHeightAboveGround, "height above ground", Dimension::kLength,
     "heightabovegroundatdronelocation agl heightaboveground"},
    {M::kRange, "range to the ground", Dimension::kLength,
     "range rangefinder heightsonar sonar distancesensor lidar ultrasonic osdvpsheight ultrasonicheight"},
    {M::kBaroHeight, "barometric height", Dimension::kLength,
     "baroalt baroheight barometricaltitude baroaltitude barometer"},
    {M::kPressure, "air pressure", Dimension::kPressure, "press pressure airpressure baro"},
    {M::kVelocityNorth, "velocity north", Dimension::kSpeed, "vn velocitynorth veln xspeed vnorth osdxspeed"},
    {M::kVelocityEast, "velocity east", Dimension::kSpeed, "ve velocityeast vele yspeed veast osdyspeed"},
    {M::kVelocityDown, "velocity down", Dimension::kSpeed, "vd velocitydown veld zspeed vdown osdzspeed"},
    {M::kSigmaHorizontal, "horizontal sigma", Dimension::kLength,
     "sh hacc horizontalaccuracy eph accuracyhorizontal sdn sde sdnorth sdeast northingrms eastingrms "
     "lateralrms"},
    {M::kSigmaVertical, "vertical sigma", Dimension::kLength,
     "sv vacc verticalaccuracy epv accuracyvertical sdu sdup sdheight elevationrms"},
    {M::kFix, "kind of fix", Dimension::kNone, "fix fixtype gpsfix"},
    {M::kGyroX, "angular rate x", Dimension::kRate,
     "wx gx gyrox gyrx xgyro angularvelocityx gyroscopex omegax"},
    {M::kGyroY, "angular rate y", Dimension::kRate,
     "wy gy gyroy gyry ygyro angularvelocityy gyroscopey omegay"},
    {M::kGyroZ, "angular rate z", Dimension::kRate,
     "wz gz gyroz gyrz zgyro angularvelocityz gyroscopez omegaz"},
    {M::kAccelX, "specific force x", Dimension::kAcceleration,
     "ax accx accelx xacc accelerometerx accelerationx linearaccelerationx"},
    {M::kAccelY, "specific force y", Dimension::kAcceleration,
     "ay accy accely yacc accelerometery accelerationy linearaccelerationy"},
    {M::kAccelZ, "specific force z", Dimension::kAcceleration,
     "az accz accelz zacc accelerometerz accelerationz linearaccelerationz"},
    {M::kQw, "attitude quaternion w", Dimension::kNone, "qw q0"},
    {M::kQx, "attitude quaternion x", Dimension::kNone, "qx q1"},
    {M::kQy, "attitude quaternion y", Dimension::kNone, "qy q2"},
    {M::kQz, "attitude quaternion z", Dimension::kNone, "qz q3"},
    {M::kRoll, "roll", Dimension::kAngle, "roll osdroll"},
    {M::kPitch, "pitch", Dimension::kAngle, "pitch osdpitch"},
    {M::kYaw, "yaw", Dimension::kAngle, "yaw heading compassheading osdyaw"},
    {M::kGimbalRoll, "gimbal roll", Dimension::kAngle, "gimbalroll gimbalrolldegree"},
    {M::kGimbalPitch, "gimbal pitch", Dimension::kAngle, "gimbalpitch gimbalpitchdegree"},
    {M::kGimbalYaw, "gimbal yaw", Dimension::kAngle, "gimbalheading gimbalyaw gimbalyawdegree"},
    {M::kSigmaTilt, "sigma of roll and pitch", Dimension::kAngle},
    {M::kSigmaYaw, "sigma of yaw", Dimension::kAngle},
    {M::kEvent, "camera event", Dimension::kNone, "event cameratrigger"},
    {M::kIsPhoto, "photo taken in this row", Dimension::kNone,
     "isphoto photo cameraisphoto photoname photofile photonumber picture shot trigger istakingphoto "
     "customisphoto foto"},
    {M::kImage, "image", Dimension::kNone,
     "image imagename imagefile img filename file sourcefile label imagelabel picturename picturefile "
     "photofilename imagefilename bild bildname bilddatei datei dateiname fichier nomfichier nomdufichier "
     "nomimage nomdelimage imagen archivo nombrearchivo nombredelarchivo nombreimagen name nom nombre"},
    {M::kEast, "easting", Dimension::kLength},
    {M::kNorth, "northing", Dimension::kLength},
    {M::kOmega, "omega", Dimension::kAngle},
    {M::kPhi, "phi", Dimension::kAngle},
    {M::kKappa, "kappa", Dimension::kAngle},
};
static_assert(std::size(kFacts) == static_cast<std::size_t>(M::kCount));

constexpr ListName kListNames[] = {
    {"east easting eastings eastingm geox e ost ostwert rechts rechtswert este est xeast xeasting utmeast "
     "utmeasting coordeast mapeast",
     M::kEast},
    {"north northing northings northingm geoy n nord nordwert hoch hochwert norte ynorth ynorthing utmnorth "
     "utmnorthing coordnorth mapnorth",
     M::kNorth},
    {"x mapx xcoord xcoordinate coordinatex coordx pointx", M::kEast, PairOrder::kXThenY},
    {"y mapy ycoord ycoordinate coordinatey coordy pointy", M::kNorth, PairOrder::kXThenY},
    {"coordinate1", M::kEast, PairOrder::kOpen},
    {"coordinate2", M::kNorth, PairOrder::kOpen},
    {"z h ht hgt mapz geoz zcoord zcoordinate coordinatez coordinate3 coordz pointz", M::kHeightAmsl},
    {"heightz", M::kHeightAboveTakeoff},  // "height/Z" of Mission Planner
    {"omega", M::kOmega},
    {"phi", M::kPhi},
    {"kappa", M::kKappa},
    {"px py imx imy pixelx pixely imagex imagey xpx ypx xpixel ypixel", M::kIgnored, PairOrder::kNamed,
     MarkPart::kPixel},
    {"u col column gcp gcpname marker point pointname pointid punkt", M::kIgnored, PairOrder::kNamed,
     MarkPart::kPoint},
    {"v row photo punktnummer"},
};

template <typename Row, std::size_t kRows>
auto RowsByName(const Row (&rows)[kRows]) {
  std::unordered_map<std::string_view, const Row*> by_name;
  std::vector<std::string_view> names;
  for (const Row& each : rows) {
    SplitBlanks(each.names, names);
    for (const std::string_view name : names) by_name.emplace(name, &each);
  }
  return by_name;
}

const MeaningFacts& FactsOf(M meaning) { return kFacts[static_cast<std::size_t>(meaning)]; }

}  // namespace

std::string_view CsvMeaningName(CsvMeaning meaning) { return FactsOf(meaning).words; }

Dimension CsvMeaningDimension(CsvMeaning meaning) { return FactsOf(meaning).dimension; }

CsvMeaning FindCsvSynonym(std::string_view letters) {
  static const auto kByName = RowsByName(kFacts);
  const auto found = kByName.find(letters);
  return found == kByName.end() ? M::kIgnored : found->second->meaning;
}

const ListName* FindListName(std::string_view letters) {
  static const auto kByName = RowsByName(kListNames);
  if (const auto found = kByName.find(letters); found != kByName.end()) return found->second;
  for (const std::string_view begin : {"easting", "northing"}) {
    if (letters.starts_with(begin)) return kByName.at(begin);
  }
  return nullptr;
}

}  // namespace skyquilt::flight
