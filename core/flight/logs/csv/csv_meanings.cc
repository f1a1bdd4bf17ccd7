#include "core/flight/logs/csv/csv_meanings.h"

#include <array>
#include <unordered_map>
#include <vector>

#include "core/flight/bytes/text_fields.h"

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
    MeaningFacts{M::kDate, "date", Dimension::kNone},
    MeaningFacts{M::kTimeOfDay, "time of day", Dimension::kNone},
    MeaningFacts{M::kLat, "latitude", Dimension::kCoordinate},
    MeaningFacts{M::kLon, "longitude", Dimension::kCoordinate},
    MeaningFacts{M::kLatLetter, "north or south", Dimension::kNone},
    MeaningFacts{M::kLonLetter, "east or west", Dimension::kNone},
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
    MeaningFacts{M::kImage, "image", Dimension::kNone},
    MeaningFacts{M::kEast, "easting", Dimension::kLength},
    MeaningFacts{M::kNorth, "northing", Dimension::kLength},
    MeaningFacts{M::kOmega, "omega", Dimension::kAngle},
    MeaningFacts{M::kPhi, "phi", Dimension::kAngle},
    MeaningFacts{M::kKappa, "kappa", Dimension::kAngle}};
static_assert(kFacts.size() == static_cast<std::size_t>(M::kCount));

template <typename Meaning>
struct Named {
  Meaning meaning;
  std::string_view names;  // apart by blanks
};
using Synonyms = Named<M>;

// Names without blanks, underscores, units and letters beyond a to z, lower case; English, and the common
// words of German, French and Spanish (Höhe is "hhe" here).
constexpr std::array kSynonyms = {
    Synonyms{M::kTime,
             "t time timestamp elapsed elapsedtime flytime offsettime timeboot osdflytime "
             "timeoffset elapsedseconds zeit tiempo"},
    Synonyms{M::kUtc,
             "utc datetime gpsdatetime utctime datetimeoriginal createdate gpsdatetimeutc "
             "dateandtime datetimeutc captured capturetime capturedat datetaken phototime "
             "timeutc gpstimestamp zeitstempel datumuhrzeit datumzeit fechahora fechayhora "
             "dateheure horodatage customdatetime"},
    Synonyms{M::kDate,
             "date datum fecha customdate gpsdate gpsdatestamp dateutc localdate "
             "dateofflight"},
    Synonyms{M::kTimeOfDay, "timeofday uhrzeit hora heure customupdatetime"},
    Synonyms{M::kLat,
             "lat latitude gpslat gpslatitude osdlatitude latitudens latitudedms latitudedd "
             "latitudedeg latwgs84 ylatitude latitudey breite breitengrad "
             "geographischebreite latitud exifgpslatitude xmpgpslatitude "
             "compositegpslatitude dronelatitude"},
    Synonyms{M::kLon,
             "lon lng long longitude gpslon gpslng gpslongitude longtitude osdlongitude "
             "longitudeew longitudedms longitudedd lonwgs84 xlongitude longitudex lnge "
             "laenge lngengrad laengengrad geographischelnge geographischelaenge longitud "
             "exifgpslongitude xmpgpslongitude compositegpslongitude dronelongitude"},
    Synonyms{M::kLatLetter, "latituderef gpslatituderef latref ns latituden latitudedirection"},
    Synonyms{M::kLonLetter, "longituderef gpslongituderef lonref ew longitudedirection"},
    Synonyms{M::kHeightEllipsoid,
             "altell ellipsoidalheight altitudewgs84 altellipsoid ellipsoidheight "
             "heightellipsoid heightellipsoidal ellipsoidischehhe ellipsoidischehoehe "
             "ellipsoidhhe hauteurellipsodale hauteurellipsoidale alturaelipsoidal hae "
             "altitudeellipsoidal altitudeellipsoid"},
    Synonyms{M::kHeightAmsl,
             "altmsl alt altitude altitudeabovesealevel altitudemsl altitudeamsl gpsaltitude "
             "absolutealtitude absalt osdaltitude zaltitude mslaltitude amsl "
             "altitudeabovemeansealevel hhe hoehe meereshhe meereshoehe hhenn altitud "
             "elevation elev orthometricheight exifgpsaltitude compositegpsaltitude"},
    Synonyms{M::kHeightAboveTakeoff,
             "heightabovetakeoff relalt relativealtitude height osdheight relativeheight "
             "relativealt altituderelative heightrelative relativehhe"},
    Synonyms{M::kHeightAboveGround, "heightabovegroundatdronelocation agl heightaboveground"},
    Synonyms{M::kRange,
             "range rangefinder heightsonar sonar distancesensor lidar ultrasonic "
             "osdvpsheight ultrasonicheight"},
    Synonyms{M::kBaroHeight, "baroalt baroheight barometricaltitude baroaltitude barometer"},
    Synonyms{M::kPressure, "press pressure airpressure baro"},
    Synonyms{M::kVelocityNorth, "vn velocitynorth veln xspeed vnorth osdxspeed"},
    Synonyms{M::kVelocityEast, "ve velocityeast vele yspeed veast osdyspeed"},
    Synonyms{M::kVelocityDown, "vd velocitydown veld zspeed vdown osdzspeed"},
    Synonyms{M::kSigmaHorizontal, "sh hacc horizontalaccuracy eph accuracyhorizontal"},
    Synonyms{M::kSigmaVertical, "sv vacc verticalaccuracy epv accuracyvertical"},
    Synonyms{M::kFix, "fix fixtype gpsfix"},
    Synonyms{M::kGyroX, "wx gx gyrox gyrx xgyro angularvelocityx gyroscopex omegax"},
    Synonyms{M::kGyroY, "wy gy gyroy gyry ygyro angularvelocityy gyroscopey omegay"},
    Synonyms{M::kGyroZ, "wz gz gyroz gyrz zgyro angularvelocityz gyroscopez omegaz"},
    Synonyms{M::kAccelX, "ax accx accelx xacc accelerometerx accelerationx linearaccelerationx"},
    Synonyms{M::kAccelY, "ay accy accely yacc accelerometery accelerationy linearaccelerationy"},
    Synonyms{M::kAccelZ, "az accz accelz zacc accelerometerz accelerationz linearaccelerationz"},
    Synonyms{M::kQw, "qw q0"},
    Synonyms{M::kQx, "qx q1"},
    Synonyms{M::kQy, "qy q2"},
    Synonyms{M::kQz, "qz q3"},
    Synonyms{M::kRoll, "roll osdroll"},
    Synonyms{M::kPitch, "pitch osdpitch"},
    Synonyms{M::kYaw, "yaw heading compassheading osdyaw"},
    Synonyms{M::kGimbalRoll, "gimbalroll gimbalrolldegree"},
    Synonyms{M::kGimbalPitch, "gimbalpitch gimbalpitchdegree"},
    Synonyms{M::kGimbalYaw, "gimbalheading gimbalyaw gimbalyawdegree"},
    Synonyms{M::kEvent, "event cameratrigger"},
    Synonyms{M::kIsPhoto,
             "isphoto photo cameraisphoto photoname photofile photonumber picture shot "
             "trigger istakingphoto customisphoto foto"},
    Synonyms{M::kImage,
             "image imagename imagefile img filename file sourcefile label imagelabel "
             "picturename picturefile photofilename imagefilename bild bildname bilddatei "
             "datei dateiname fichier nomfichier nomdufichier nomimage nomdelimage imagen "
             "archivo nombrearchivo nombredelarchivo nombreimagen name nom nombre"}};

using ListNames = Named<ListColumn>;

// "x" and "y" are columns, but say no order: surveyors' x is north in half of the world.
constexpr std::array kListNames = {
    ListNames{
        ListColumn::kEast,
        "east easting eastings eastingm geox e ost ostwert rechts rechtswert este est xeast xeasting utmeast utmeasting "
        "coordeast mapeast"},
    ListNames{
        ListColumn::kNorth,
        "north northing northings northingm geoy n nord nordwert hoch hochwert norte ynorth ynorthing utmnorth "
        "utmnorthing coordnorth mapnorth"},
    ListNames{
        ListColumn::kOther,
        "x y z h mapx mapy mapz geoz xcoord ycoord zcoord px py imx imy pixelx pixely u v col row photo gcp "
        "gcpname point pointname pointid punkt punktnummer omega phi kappa"}};

template <typename Meaning, std::size_t kRows>
std::unordered_map<std::string_view, Meaning> MeaningsByName(const std::array<Named<Meaning>, kRows>& rows) {
  std::unordered_map<std::string_view, Meaning> meanings;
  std::vector<std::string_view> names;
  for (const Named<Meaning>& each : rows) {
    SplitBlanks(each.names, names);
    for (const std::string_view name : names) meanings.emplace(name, each.meaning);
  }
  return meanings;
}

const MeaningFacts& FactsOf(M meaning) { return kFacts[static_cast<std::size_t>(meaning)]; }

}  // namespace

std::string_view CsvMeaningName(CsvMeaning meaning) { return FactsOf(meaning).words; }

Dimension CsvMeaningDimension(CsvMeaning meaning) { return FactsOf(meaning).dimension; }

CsvMeaning FindCsvSynonym(std::string_view letters) {
  static const std::unordered_map<std::string_view, M> kMeanings = MeaningsByName(kSynonyms);
  const auto found = kMeanings.find(letters);
  return found == kMeanings.end() ? M::kIgnored : found->second;
}

ListColumn FindListColumn(std::string_view letters) {
  static const std::unordered_map<std::string_view, ListColumn> kColumns = MeaningsByName(kListNames);
  const auto found = kColumns.find(letters);
  return found == kColumns.end() ? ListColumn::kNone : found->second;
}

}  // namespace skyquilt::flight
