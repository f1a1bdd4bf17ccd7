// Lists of photos below a line of names: whichever program wrote them, columns mean what their names say.
#include <gmock/gmock.h>

#include <string>
#include <utility>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/list_columns.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {
namespace {

using geo::DegToRad;
using ::testing::HasSubstr;

FlightLog ReadList(const std::string& text) {
  auto log = ParseLog("list.csv", BytesOf(text));
  EXPECT_TRUE(log.ok()) << (log ? "" : log.error().message) << "\n" << text;
  return log ? *std::move(log) : FlightLog();
}

CameraEvent FirstRow(const std::string& text) {
  const FlightLog log = ReadList(text);
  EXPECT_FALSE(log.events.empty()) << text;
  return log.events.empty() ? CameraEvent() : log.events.front();
}

constexpr const char* kWkt =
    "PROJCS[\"WGS 84 / UTM zone 15N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,"
    "298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],"
    "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],"
    "PARAMETER[\"central_meridian\",-93],PARAMETER[\"scale_factor\",0.9996],"
    "PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1],"
    "AUTHORITY[\"EPSG\",\"32615\"]]";

TEST(NamedLists, AColumnOfZonesNamesTheSystem) {
  for (const char* zone : {"15N", "15T", "UTM 15N"}) {
    const FlightLog log =
        ReadList(std::string("image,easting,northing,zone,altitude\n") + "a.jpg,576667.1,5188164.6," + zone +
                 ",198.3\n" + "b.jpg,576691.6,5188169.6,15T,198.3\n");
    EXPECT_EQ(log.written_system, "EPSG:32615") << zone;
    ASSERT_EQ(log.events.size(), 2u) << zone;
    ASSERT_TRUE(log.events[0].position) << zone;
    EXPECT_NEAR(log.events[0].position->lat_deg, 46.84261, 2e-5) << zone;
  }
  const std::string rows = "a.jpg,576667.1,5188164.6,15N\nb.jpg,123000.0,5188169.6,16N\n";
  const auto several = ParseLog("list.csv", BytesOf("image,easting,northing,UTM zone\n" + rows));
  ASSERT_FALSE(several.ok());
  EXPECT_EQ(WhyOf(several.error()).code, RemarkCode::kListOfSeveralZones);
  const FlightLog named = ReadList("EPSG:25832\nimage,easting,northing,zone\n" + rows);
  EXPECT_EQ(named.written_system, "EPSG:25832") << "above the rows";
  for (const char* field : {"Lisbon", "25832"}) {
    const FlightLog of_field =
        ReadList(std::string("image,easting,northing,zone\na.jpg,576667.1,5188164.6,") + field + "\n");
    EXPECT_TRUE(of_field.written_system.empty()) << field;
  }
}

TEST(NamedLists, ReadsWhatMetashapeExportsInAProjectedSystem) {
  const std::string names =
      "#Label,X/Easting,Y/Northing,Z/Altitude,Accuracy_X_(m),Accuracy_Y_(m),Accuracy_Z_(m),Yaw,Pitch,Roll\n";
  for (const std::string& system : {std::string("# CoordinateSystem: ") + kWkt,
                                    std::string("# CoordinateSystem: WGS 84 / UTM zone 15N (EPSG::32615)")}) {
    for (const char* photo : {"DJI_0018.JPG", "DJI_0018"}) {
      const FlightLog log =
          ReadList(system + "\n" + names + photo + ",576691.665,5188169.628,158.5,0.02,0.02,0.03,90,1,2\n");
      ASSERT_EQ(log.events.size(), 1u) << system;
      const CameraEvent& event = log.events[0];
      EXPECT_EQ(event.image_name, photo);
      ASSERT_TRUE(event.position);
      EXPECT_NEAR(event.position->lat_deg, 46.84265, 1e-4);
      EXPECT_EQ(event.height_ellipsoid_m, 158.5);
      ASSERT_TRUE(event.sigma_in_ned_m);
      EXPECT_DOUBLE_EQ(event.sigma_in_ned_m->x(), 0.02);
      EXPECT_DOUBLE_EQ(event.sigma_in_ned_m->z(), 0.03);
      ASSERT_TRUE(event.yaw_pitch_roll_rad);
      EXPECT_NEAR(event.yaw_pitch_roll_rad->x(), DegToRad(90.0), 1e-12);
      EXPECT_FALSE(log.written_system.empty());
      EXPECT_TRUE(log.written_order_is_named);
      EXPECT_TRUE(log.warnings.empty()) << ::testing::PrintToString(InWords(log.warnings));
    }
  }
}

TEST(NamedLists, RefusesASystemThatIsNotKnown) {
  const auto log =
      ParseLog("list.csv", BytesOf("# CRS: EPSG:99999\nphoto,easting,northing\na.jpg,576691.6,5188169.6\n"));
  ASSERT_FALSE(log.ok());
  EXPECT_EQ(WhyOf(log.error()).code, RemarkCode::kSystemUnknown);
}

TEST(NamedLists, ReadsAnyNamesOfAPlane) {
  for (const char* names : {"Photo,Northing,Easting,Height", "Bildname,Hochwert,Rechtswert,H\xC3\xB6he",
                            "File Name,North (m),East (m),elevation", "label,Y/Northing,X/Easting,Z/Altitude",
                            "name,n,e,h", "image,y,x,z"}) {
    const FlightLog log = ReadList(std::string(names) + "\nDJI_0018,5188169.628,576691.665,58.5\n");
    ASSERT_EQ(log.events.size(), 1u) << names;
    ASSERT_TRUE(log.events[0].written) << names;
    EXPECT_DOUBLE_EQ(log.events[0].written->x, 576691.665) << names;
    EXPECT_DOUBLE_EQ(log.events[0].written->y, 5188169.628) << names;
    EXPECT_FALSE(log.events[0].position) << names;
    EXPECT_EQ(log.events[0].height_ellipsoid_m, 58.5) << names;
    EXPECT_TRUE(log.written_system.empty()) << names;
    EXPECT_EQ(log.written_order_is_named, std::string(names) != "image,y,x,z") << names;
  }
}

TEST(NamedLists, FindsTheZoneOfUtmBehindTheNamesOfColumns) {
  const auto system_of = [](const std::string& east) {
    return ReadList("Some flight\nPhoto;" + east + ";Northing;Height\nDJI_0018;576691.6;5188169.6;58.5\n")
        .written_system;
  };
  EXPECT_EQ(system_of("Easting (UTM 15T)"), "EPSG:32615");
  EXPECT_EQ(system_of("Easting [m] (WGS84 / UTM 15N)"), "EPSG:32615");
  EXPECT_EQ(system_of("Easting (UTM, m)"), "");
}

TEST(NamedLists, ReadsPlacesInAPlaneBesideTimesOfAnyKind) {
  for (const char* time : {"12345.5", "2016-06-23 21:31:09", "0:12:05"}) {
    const CameraEvent event = FirstRow("EPSG:32615\nImage,Timestamp,Easting,Northing,Height\nDJI_0018.JPG," +
                                       std::string(time) + ",576691.665,5188169.628,158.5\n");
    EXPECT_EQ(event.image_name, "DJI_0018.JPG") << time;
    ASSERT_TRUE(event.position) << time;
    EXPECT_NEAR(event.position->lat_deg, 46.84265, 1e-4) << time;
    EXPECT_EQ(event.height_ellipsoid_m, 158.5) << time;
    EXPECT_FALSE(event.has_time) << time;
  }
}

TEST(NamedLists, ReadsAllOfAListBesideAColumnOfTimes) {
  const FlightLog log = ReadList(
      "#Image,Date,Time,Latitude,Longitude,H-Ell (m),Omega,Phi,Kappa,XY accuracy,Z accuracy\n"
      "a.jpg,2016-06-23,21:31:09,47.4,8.5,500,0,0,-30,0.02,0.03\n"
      "b.jpg,2016-06-23,21:31:12,47.401,8.5,500,0,0,-30,0.02,0.03\n");
  EXPECT_TRUE(log.gnss.empty()) << "rows of photos are no track";
  ASSERT_EQ(log.events.size(), 2u);
  const CameraEvent& event = log.events[1];
  EXPECT_EQ(event.image_name, "b.jpg");
  EXPECT_EQ(event.height_ellipsoid_m, 500.0);
  ASSERT_TRUE(event.yaw_pitch_roll_rad);
  EXPECT_NEAR(event.yaw_pitch_roll_rad->x(), DegToRad(30.0), 1e-9);
  ASSERT_TRUE(event.sigma_in_ned_m);
  EXPECT_DOUBLE_EQ(event.sigma_in_ned_m->x(), 0.02);
  EXPECT_DOUBLE_EQ(event.sigma_in_ned_m->z(), 0.03);
}

TEST(NamedLists, ReadsAllOfAListBesideACounter) {
  struct Counter {
    std::string name, first, second;
  };
  for (const auto& [name, first, second] :
       {Counter{"Timestamp", "1466717469", "1466717472.5"}, Counter{"Time (s)", "423069", "423072.5"}}) {
    const FlightLog log = ReadList(
        "#Image," + name + ",Latitude,Longitude,H-Ell (m),Omega,Phi,Kappa,XY accuracy,Z accuracy\na.jpg," +
        first + ",47.4,8.5,500,0,0,-30,0.02,0.03\nb.jpg," + second + ",47.4001,8.5,500,0,0,-30,0.02,0.03\n");
    ASSERT_EQ(log.events.size(), 2u) << first;
    const CameraEvent& event = log.events[1];
    EXPECT_EQ(event.image_name, "b.jpg");
    EXPECT_DOUBLE_EQ(event.t_s, 3.5);
    EXPECT_EQ(event.height_ellipsoid_m, 500.0);
    ASSERT_TRUE(event.yaw_pitch_roll_rad);
    EXPECT_NEAR(event.yaw_pitch_roll_rad->x(), DegToRad(30.0), 1e-9);
    ASSERT_EQ(log.gnss.size(), 2u) << first;
    EXPECT_EQ(log.gnss[1].height_ellipsoid_m, 500.0);
    EXPECT_EQ(log.gnss[1].sigma_horizontal_m, 0.02);
    EXPECT_EQ(log.gnss[1].sigma_vertical_m, 0.03);
  }
}

TEST(NamedLists, ReadsDegreesAsXAndY) {
  const FlightLog log = ReadList("#name,x,y,alt,yaw,pitch,roll\na.jpg,8.5,47.4,500,90,1,2\n");
  ASSERT_EQ(log.events.size(), 1u);
  ASSERT_TRUE(log.events[0].position);
  EXPECT_DOUBLE_EQ(log.events[0].position->lon_deg, 8.5);
  EXPECT_TRUE(log.events[0].yaw_pitch_roll_rad);
  EXPECT_FALSE(log.written_order_is_named);
  EXPECT_FALSE(log.written_order_is_assumed);
}

TEST(NamedLists, ReadsOmegaPhiKappaOfAllPrograms) {
  for (const char* text :
       {"#Label,X/Longitude,Y/Latitude,Z/Altitude,Omega,Phi,Kappa\na.jpg,8.5,47.4,500,0,0,-92.5\n",
        "imageName X Y Z Omega Phi Kappa\na.jpg 576691.665 5188169.628 500 0 0 -92.5\n"}) {
    const CameraEvent event = FirstRow(text);
    ASSERT_TRUE(event.yaw_pitch_roll_rad) << text;
    EXPECT_NEAR(event.yaw_pitch_roll_rad->x(), DegToRad(92.5), 1e-12) << text;
    EXPECT_EQ(event.attitude_kind, AttitudeKind::kAirframe) << text;
    EXPECT_EQ(event.height_ellipsoid_m, 500.0) << text;
  }
}

TEST(NamedLists, ReadsWhatRealityCaptureExportsWithItsLenses) {
  const FlightLog log = ReadList(
      "#cameras 1\n#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2\n"
      "DJI_0018.JPG,576691.665,5188169.628,158.5,90,1,2,24.1,0.01,-0.02,0.1,0,0,0,0,0\n");
  ASSERT_EQ(log.events.size(), 1u);
  ASSERT_TRUE(log.events[0].written);
  EXPECT_DOUBLE_EQ(log.events[0].written->x, 576691.665);
  EXPECT_DOUBLE_EQ(log.events[0].written->y, 5188169.628);
  EXPECT_EQ(log.events[0].height_ellipsoid_m, 158.5);
  ASSERT_TRUE(log.events[0].yaw_pitch_roll_rad);
  EXPECT_NEAR(log.events[0].yaw_pitch_roll_rad->x(), DegToRad(90.0), 1e-12);
}

TEST(NamedLists, ReadsMetashapesPhotosWithoutTheirEndings) {
  const CameraEvent event = FirstRow(
      "# Cameras (1)\n# PhotoID, X, Y, Z, Omega, Phi, Kappa, r11, r12, r13, r21, r22, r23, r31, r32, r33\n"
      "IMG_0001_6\t8.5\t47.4\t500\t0\t0\t-92.5\t1\t0\t0\t0\t1\t0\t0\t0\t1\n");
  EXPECT_EQ(event.image_name, "IMG_0001_6");
  ASSERT_TRUE(event.position);
  EXPECT_DOUBLE_EQ(event.position->lat_deg, 47.4);
  ASSERT_TRUE(event.yaw_pitch_roll_rad);
  EXPECT_NEAR(event.yaw_pitch_roll_rad->x(), DegToRad(92.5), 1e-12);
}

TEST(NamedLists, FindsEachAngleByItsOwnNameAndUnit) {
  const auto yaw_deg = [](const std::string& names, const std::string& cells) {
    const CameraEvent event =
        FirstRow("image,latitude,longitude,altitude," + names + "\na.jpg,47.4,8.5,500," + cells + "\n");
    EXPECT_TRUE(event.yaw_pitch_roll_rad) << names;
    return event.yaw_pitch_roll_rad ? event.yaw_pitch_roll_rad->x() / DegToRad(1.0) : -1.0;
  };
  EXPECT_NEAR(yaw_deg("omega [rad],phi [rad],kappa [rad]", "0,0,-0.5"), 0.5 / DegToRad(1.0), 1e-9);
  EXPECT_NEAR(yaw_deg("omega [gon],phi [gon],kappa [gon]", "0,0,-100"), 90.0, 1e-9);
  EXPECT_NEAR(yaw_deg("omega_rad,phi_rad,kappa_rad", "0,0,-0.5"), 0.5 / DegToRad(1.0), 1e-9);
  EXPECT_NEAR(yaw_deg("omega,phi,kappa", "0,0,390"), 9.0, 1e-9) << "more than a turn of degrees";
  EXPECT_NEAR(yaw_deg("omega,phi,kappa", "0,0,350"), 10.0, 1e-9);
  EXPECT_NEAR(yaw_deg("yaw [rad],pitch [rad],roll [rad]", "0.5,0,0"), 0.5 / DegToRad(1.0), 1e-9);
  EXPECT_NEAR(yaw_deg("yaw,roll,pitch", "30,1,2"), 30.0, 1e-9);
  EXPECT_NEAR(yaw_deg("roll,pitch,yaw,acc,acc", "1,2,30,0.5,1.5"), 30.0, 1e-9);
}

TEST(NamedLists, FindsAccuraciesByTheirNamesAndUnits) {
  const auto sigma = [](const std::string& names, const std::string& cells) {
    return FirstRow("image,latitude,longitude,altitude," + names + "\na.jpg,47.4,8.5,500," + cells + "\n")
        .sigma_in_ned_m.value_or(Eigen::Vector3d::Zero());
  };
  EXPECT_NEAR(sigma("accuracy horizontal [feet],accuracy vertical [feet]", "1,2").z(), 0.6096, 1e-9);
  EXPECT_NEAR(sigma("acc,acc", "0.5,1.5").z(), 1.5, 1e-9);
  EXPECT_NEAR(sigma("accuracy", "0.5").x(), 0.5, 1e-9);
  EXPECT_NEAR(sigma("accuracy_yaw,sigma_v,sigma_h", "9,1.5,0.5").x(), 0.5, 1e-9);
}

TEST(NamedLists, FindsAccuraciesAsMetashapeAndPostProcessorsNameThem) {
  const std::string of_metashape = "Accuracy_X/Y/Z_(m),Accuracy_Yaw/Pitch/Roll_(deg)";
  for (const auto& [names, cells] : {std::pair{of_metashape, std::string("0.02,1")},
                                     {"stdH,stdV", "0.02,0.04"},
                                     {"HRMS,VRMS", "0.02,0.04"},
                                     {"lat_std,alt_std", "0.02,0.04"},
                                     {"StdDev X (m),StdDev Z (m)", "0.02,0.04"},
                                     {"Horizontal precision,Vertical precision", "0.02,0.04"}}) {
    const CameraEvent event = FirstRow("#Label,X/Longitude,Y/Latitude,Z/Altitude," + names +
                                       "\na.jpg,8.5,47.4,500," + cells + "\n");
    ASSERT_TRUE(event.sigma_in_ned_m) << names;
    EXPECT_NEAR(event.sigma_in_ned_m->x(), 0.02, 1e-9) << names;
    EXPECT_NEAR(event.sigma_in_ned_m->z(), 0.04, 1e-9) << names;
  }
  EXPECT_FALSE(FirstRow("image,latitude,longitude,RMS\na.jpg,47.4,8.5,0.6\n").sigma_in_ned_m) << "of what?";
}

TEST(NamedLists, FindsAccuraciesAsReceiversProgramsNameThem) {
  for (const char* text : {"image,latitude(deg),longitude(deg),height(m),Q,ns,sdn(m),sde(m),sdu(m)\n"
                           "a.jpg,47.4,8.5,500,1,15,0.01,0.02,0.03\n",
                           "Name,Easting,Northing,Elevation,Easting RMS,Northing RMS,Elevation RMS\n"
                           "a.jpg,576691.6,5188169.6,500,0.01,0.02,0.03\n"}) {
    const FlightLog log = ReadList(text);
    ASSERT_EQ(log.events.size(), 1u) << text;
    ASSERT_TRUE(log.events[0].sigma_in_ned_m) << text;
    EXPECT_DOUBLE_EQ(log.events[0].sigma_in_ned_m->x(), 0.01) << text;
    EXPECT_DOUBLE_EQ(log.events[0].sigma_in_ned_m->z(), 0.03) << text;
    EXPECT_TRUE(log.warnings.empty()) << ::testing::PrintToString(InWords(log.warnings));
  }
}

TEST(NamedLists, CountsABareAltitudeFromTheZeroOfListsWhateverThePhotosAreCalled) {
  for (const char* photo : {"a.jpg", "a"}) {
    const std::string row = std::string(photo) + ",47.4,8.5,500\n";
    EXPECT_EQ(FirstRow("image,latitude,longitude,altitude\n" + row).height_ellipsoid_m, 500.0) << photo;
    EXPECT_EQ(FirstRow("filename,lat,lon,alt\n" + row).height_ellipsoid_m, 500.0) << photo;
    EXPECT_EQ(FirstRow("image,latitude,longitude,altitude AMSL\n" + row).height_amsl_m, 500.0) << photo;
    EXPECT_EQ(FirstRow("SourceFile,GPSLatitude,GPSLongitude,GPSAltitude\n" + row).height_amsl_m, 500.0);
  }
  EXPECT_EQ(FirstRow("EPSG:32615+5773\nimage,x,y,z\na.jpg,576691.6,5188169.6,500\n").height_amsl_m, 500.0);
}

TEST(NamedLists, FindsHeightsByTheirWordsInOtherLanguages) {
  const auto row = [](const std::string& height, const std::string& cell) {
    return FirstRow("fichier;latitude;longitude;" + height + "\na.jpg;47,4;8,5;" + cell + "\n");
  };
  for (const char* above_sea : {"H\xC3\xB6he \xC3\xBC"
                                "ber NHN (m)",
                                "H\xC3\xB6he_\xC3\xBC"
                                "ber_NN",
                                "Hoehe ueber NHN"})
    EXPECT_EQ(row(above_sea, "500").height_amsl_m, 500.0) << above_sea;
  for (const char* bare : {"hauteur", "Altura (m)", "Elevaci\xC3\xB3n", "Cota"})
    EXPECT_EQ(row(bare, "500").height_ellipsoid_m, 500.0) << bare;
  EXPECT_EQ(row("height above ellipsoid", "500").height_ellipsoid_m, 500.0);
  for (const char* above_takeoff : {"hauteur", "altura"})
    EXPECT_EQ(row(above_takeoff, "60").height_above_takeoff_m, 60.0) << above_takeoff;
  EXPECT_EQ(row("agl_m", "60").height_above_ground_m, 60.0);
}

TEST(NamedLists, FindsWhatHeightsOfAbbreviatedNamesCountFrom) {
  const auto row = [](const std::string& height) {
    return FirstRow("image;easting;northing;" + height + "\na.jpg;576691.6;5188169.6;500\n");
  };
  for (const char* name : {"h_ell", "H-Ell", "H-Ell (m)", "h ell. [m]", "Z_WGS84", "Ell. Ht", "Ht", "Hgt"})
    EXPECT_EQ(row(name).height_ellipsoid_m, 500.0) << name;
  for (const char* name : {"Z_NAVD88", "H_NHN [m]", "H \xC3\xBC. NHN", "H-MSL", "Ortho. Height"}) {
    EXPECT_EQ(row(name).height_amsl_m, 500.0) << name;
    EXPECT_FALSE(row(name).height_ellipsoid_m) << name;
  }
  EXPECT_NEAR(row("h_ell (ft)").height_ellipsoid_m.value_or(0.0), 152.4, 1e-9);
}

TEST(NamedLists, ReadsTheFieldsThatArcGisAdds) {
  const CameraEvent event = FirstRow("Name,POINT_X,POINT_Y,POINT_Z\na.jpg,8.5,47.4,500\n");
  ASSERT_TRUE(event.position);
  EXPECT_DOUBLE_EQ(event.position->lat_deg, 47.4);
  EXPECT_EQ(event.height_ellipsoid_m, 500.0);
}

// location.txt of its geotagging; which of its two heights it wrote, the numbers tell.
TEST(NamedLists, TakesTheHeightsOfMissionPlanner) {
  const std::string names = "#name latitude/Y longitude/X height/Z yaw pitch roll SAlt\n";
  const CameraEvent above_sea = FirstRow(names + "a.jpg 47.4 8.5 523.5 90 2 1 0\n");
  EXPECT_EQ(above_sea.height_amsl_m, 523.5);
  EXPECT_FALSE(above_sea.height_ellipsoid_m);
  ASSERT_TRUE(above_sea.position);
  EXPECT_DOUBLE_EQ(above_sea.position->lat_deg, 47.4);
  ASSERT_TRUE(above_sea.yaw_pitch_roll_rad);
  EXPECT_NEAR(above_sea.yaw_pitch_roll_rad->x(), DegToRad(90.0), 1e-12);
  const CameraEvent above_takeoff = FirstRow(names + "a.jpg 47,4 8,5 83,5 90 2 1 0\n");
  EXPECT_EQ(above_takeoff.height_above_takeoff_m, 83.5);
  EXPECT_FALSE(above_takeoff.height_amsl_m);
}

TEST(NamedLists, ReadsSmallDegreesOfPhotos) {
  const FlightLog log =
      ReadList("image,lat,lon,alt\na.jpg,470123456,81234567,512345\nb.jpg,470123466,81234567,515345\n");
  ASSERT_EQ(log.events.size(), 2u);
  ASSERT_TRUE(log.events[0].position);
  EXPECT_NEAR(log.events[0].position->lat_deg, 47.0123456, 1e-9);
  EXPECT_NEAR(log.events[0].height_ellipsoid_m.value_or(0.0), 512.345, 1e-6);
}

TEST(NamedLists, TakesRowsThatAreCutOtherwiseThanTheirNames) {
  for (const char* text :
       {"EPSG:32615\nimage x y z\na.jpg\t576691.6\t5188169.6\t158.5\n",
        "EPSG:32615\n# columns: image x y z remark\na.jpg 576691.6 5188169.6 158.5 ok\n"}) {
    const CameraEvent event = FirstRow(text);
    ASSERT_TRUE(event.position) << text;
    EXPECT_NEAR(event.position->lat_deg, 46.84265, 1e-3) << text;
    EXPECT_EQ(event.height_ellipsoid_m, 158.5) << text;
  }
}

// "Name" is the mission's in some tables.
TEST(NamedLists, TakesPhotosFromTheColumnThatNamesPictures) {
  const auto first = [](const std::string& names, const std::string& ending) {
    const std::string rows =
        "Mission 7,DJI_1" + ending + ",46.8,8.1,500\nMission 7,DJI_2" + ending + ",46.9,8.1,501\n";
    return FirstRow(names + ",lat,lon,alt\n" + rows).image_name.value_or("");
  };
  EXPECT_EQ(first("Name,Filename", ".JPG"), "DJI_1.JPG");
  EXPECT_EQ(first("Name,Filename", ""), "DJI_1");
  EXPECT_EQ(first("Name,Photo", ".JPG"), "DJI_1.JPG");
  EXPECT_EQ(FirstRow("image,name,lat,lon,alt\na.jpg,b.jpg,46.8,8.1,500\n").image_name, "a.jpg");
}

TEST(NamedLists, KeepsUnitsBehindBlanksWithTheirNames) {
  const CameraEvent event = FirstRow(
      "EPSG:4326\nimage_name geo_x geo_y geo_z yaw (degrees) pitch (decimal degrees) roll (degrees) sh (m)\n"
      "a.jpg 8.1 46.8 500 90 1 2 0.5\n");
  ASSERT_TRUE(event.yaw_pitch_roll_rad);
  EXPECT_NEAR(event.yaw_pitch_roll_rad->y(), DegToRad(1.0), 1e-12);
  EXPECT_NEAR(event.yaw_pitch_roll_rad->z(), DegToRad(2.0), 1e-12);
  ASSERT_TRUE(event.sigma_in_ned_m);
  EXPECT_DOUBLE_EQ(event.sigma_in_ned_m->x(), 0.5);
}

TEST(NamedLists, KnowsPhotosByTheirEndingsWhateverTheirColumnIsCalled) {
  for (const char* text : {"EPSG:4326\nid lon lat alt\na.jpg 8.1 46.8 500\n",
                           "Camera,Latitude,Longitude,Altitude\n\"a.jpg\",46.8,8.1,500\n",
                           "Nr;Foto-Datei;Breite;L\xC3\xA4nge;H\xC3\xB6he\n1;a.jpg;46,8;8,1;500\n"}) {
    const CameraEvent event = FirstRow(text);
    EXPECT_EQ(event.image_name, "a.jpg") << text;
    ASSERT_TRUE(event.position) << text;
    EXPECT_DOUBLE_EQ(event.position->lat_deg, 46.8) << text;
  }
}

TEST(NamedLists, CountsDegreesInNoSystemOfThePlaneBesideThem) {
  const FlightLog log = ReadList(
      "image,lat,lon,easting (EPSG:25832),northing (EPSG:25832)\na.jpg,46.8,8.1,431311.0,5183418.0\n");
  ASSERT_EQ(log.events.size(), 1u);
  ASSERT_TRUE(log.events[0].position);
  EXPECT_DOUBLE_EQ(log.events[0].position->lat_deg, 46.8);
  EXPECT_TRUE(log.written_system.empty());
}

TEST(NamedLists, HaveNoHeightsThatNoAircraftReaches) {
  const FlightLog log =
      ReadList("image,lat,lon,alt\na.jpg,46.8,8.1,-9999\nb.jpg,46.9,8.1,501\nc.jpg,46.9,8.2,1000000000\n");
  ASSERT_EQ(log.events.size(), 3u);
  EXPECT_FALSE(log.events[0].height_ellipsoid_m);
  EXPECT_EQ(log.events[1].height_ellipsoid_m, 501.0);
  EXPECT_FALSE(log.events[2].height_ellipsoid_m);
  const Remark said(RemarkCode::kHeightsBeyond, {{"rows", 2}, {"height_m", -9999.0}});
  EXPECT_THAT(log.warnings, ::testing::Contains(said)) << "of both, with the first";
}

// As spreadsheets of some countries keep them; they were places off Ghana.
TEST(NamedLists, HaveNoDegreesThatLostTheirPoint) {
  const FlightLog log =
      ReadList("image;lat;lon;alt\na.jpg;46.842.607;8.123.456;500\nb.jpg;46.842.612;8.123.461;500\n");
  ASSERT_EQ(log.events.size(), 2u);
  for (const CameraEvent& event : log.events) EXPECT_FALSE(event.position || event.written);
  EXPECT_THAT(InWords(log.warnings), ::testing::Contains(HasSubstr("\"46.842.607\"")));
  EXPECT_TRUE(
      FirstRow("image;lat;lon;alt\na.jpg;468426070;81234560;500\nb.jpg;468426120;81234610;500\n").position);
}

// Whole degrees, whose minutes are in columns of their own, are up to a hundred kilometres off.
TEST(NamedLists, HaveNoDegreesWithoutTheirMinutes) {
  const auto reads = [](const std::string& names, const std::string& row) {
    return ParseLog("list.csv", BytesOf(names + "\n" + row + "\n" + row + "\n")).ok();
  };
  const std::string in_parts = "a.jpg,46,50,33.39,8,7,24.4,500";
  EXPECT_FALSE(reads("image,lat_deg,lat_min,lat_sec,lon_deg,lon_min,lon_sec,alt", in_parts));
  EXPECT_FALSE(reads(
      "image,Latitude (deg),Latitude (min),Latitude (sec),Longitude (deg),Longitude (min),Longitude (sec),alt",
      in_parts));
  EXPECT_TRUE(
      reads("image,lat_deg,lat_min,lat_max,lon_deg,lon_min,lon_max,alt", "a.jpg,46.84,46,47,8.1,8,9,500"))
      << "the least and the most of an area";
  EXPECT_DOUBLE_EQ(FirstRow("image,latitude,longitude,lat_deg,lat_min,lon_deg,lon_min\n"
                            "a.jpg,46.84,8.1,46,50.4,8,6\n")
                       .position.value_or(geo::LatLon())
                       .lat_deg,
                   46.84);
}

TEST(NamedLists, LeavesPointsProseAndLogsAlone) {
  const auto reads = [](std::string_view line, std::string_view rows) {
    return ReadListHeading(line, LineReader(rows)).has_value();
  };
  EXPECT_TRUE(reads("image,x,y,z", "a.jpg,1,2,3\n"));
  EXPECT_FALSE(reads("image,x,y,z,px,py,point", "a.jpg,1,2,3,4,5,p\n")) << "marks of surveyed points";
  EXPECT_FALSE(reads("gcp,lat,lon,alt,px,py,image", "p,46.8,8.1,500,4,5,a.jpg\n")) << "marks too";
  EXPECT_FALSE(reads("gcp,lat,lon,alt,xpixel,ypixel,image", "p,46.8,8.1,500,4,5,a.jpg\n")) << "the same";
  EXPECT_FALSE(reads("xcoordinate,ycoordinate,zcoordinate,column,line,photo", "1,2,3,4,5,a.jpg\n"))
      << "and these";
  EXPECT_TRUE(reads("point,lat,lon,image", "1,46.8,8.1,a.jpg\n")) << "numbered photos";
  EXPECT_FALSE(reads("PhotoID,x,y,z", "1,2,3,4\n")) << "numbers name no photo";
  EXPECT_FALSE(reads("photo of the x and y axes", "taken in the evening\n"));
  EXPECT_FALSE(reads("time,x,y,z", "1,2,3,4\n")) << "names no photo";
  EXPECT_FALSE(reads("image,x,z", "a.jpg,1,2\n")) << "one coordinate";
}

}  // namespace
}  // namespace skyquilt::flight
