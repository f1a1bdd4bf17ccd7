// Folders and flights: names, order, doubles, side files; one bad file never fails the flight.
#include "core/flight/read_flight.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/flight/lists/file_kinds.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using test::ErrorOf;
using test::TemporaryFolder;
using test::ValueOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

Bytes PhotoAt(double lat_deg, const std::string& time) {
  ExifWriter exif;
  exif.Position(lat_deg, 7.0);
  if (!time.empty()) exif.Ascii(ExifIfd::kExif, 0x9003, time);
  return JpegHeader({.exif = exif.Write()});
}

Flight Read(const TemporaryFolder& folder) {
  SilentProgress progress;
  return ValueOf(ReadFlight(ValueOf(ListInputFiles({folder.path()})), 0, progress));
}

std::vector<std::string> Names(const Flight& flight) {
  std::vector<std::string> names;
  for (const Photo& photo : flight.photos) names.push_back(photo.name);
  return names;
}

TEST(ReadFlight, OrdersByTimeThenNameAndPutsPhotosWithoutTimeLast) {
  const TemporaryFolder folder;
  folder.Write("a.jpg", PhotoAt(1.0, ""));
  folder.Write("b.jpg", PhotoAt(1.1, "2021:06:03 12:00:02"));
  folder.Write("c.jpg", PhotoAt(1.2, "2021:06:03 12:00:01"));
  folder.Write("d.jpg", PhotoAt(1.3, "2021:06:03 12:00:01"));
  EXPECT_EQ(Names(Read(folder)), (std::vector<std::string>{"c.jpg", "d.jpg", "b.jpg", "a.jpg"}));
}

TEST(ReadFlight, OrdersByTheNumbersInNames) {
  const TemporaryFolder folder;
  folder.Write("frame_10.jpg", PhotoAt(1.0, "2021:06:03 12:00:01"));
  folder.Write("frame_9.jpg", PhotoAt(1.1, "2021:06:03 12:00:01"));
  folder.Write("frame_0100.jpg", PhotoAt(1.2, "2021:06:03 12:00:01"));
  EXPECT_EQ(Names(Read(folder)), (std::vector<std::string>{"frame_9.jpg", "frame_10.jpg", "frame_0100.jpg"}));
}

TEST(ReadFlight, LeavesOutBadFilesWithTheirReasonsAndKeepsTheRest) {
  const TemporaryFolder folder;
  folder.Write("good.jpg", PhotoAt(1.0, "2021:06:03 12:00:00"));
  folder.Write("no_gps.jpg", JpegHeader({}));
  folder.Write("empty.jpg", "");
  folder.Write("letter.jpg", "hello");
  folder.Write("cut.jpg", JpegHeader({.has_end = false}));
  folder.Write("film.mp4", Bytes{0, 0, 0, 32, 'f', 't', 'y', 'p', 'i', 's', 'o', 'm'});
  folder.Write("flight.BIN", Bytes{0xA3, 0x95, 0x80});
  folder.Write("notes.txt", "x");
  folder.Write(".hidden.jpg", "");
  const Flight flight = Read(folder);
  EXPECT_EQ(Names(flight), (std::vector<std::string>{"good.jpg", "no_gps.jpg"}));
  EXPECT_TRUE(flight.photos[0].position);
  EXPECT_FALSE(flight.photos[1].position);
  ASSERT_EQ(flight.left_out.size(), 3u);
  EXPECT_EQ(flight.left_out[0].name, "cut.jpg");
  EXPECT_EQ(flight.left_out[0].code, ErrorCode::kCorrupt);
  EXPECT_THAT(InWords(flight.left_out[1].reason), HasSubstr("empty"));
  EXPECT_THAT(InWords(flight.left_out[2].reason), HasSubstr("text file"));
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("film.mp4 is a film")));
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("1 of 2 photos carry no usable position")));
}

TEST(ReadFlight, SaysThatSmallCopiesBesideFilmsAreNotUsed) {
  const Bytes film{0, 0, 0, 32, 'f', 't', 'y', 'p', 'i', 's', 'o', 'm'};
  const TemporaryFolder folder;
  for (const char* name : {"DJI_0001.LRF", "DJI_0001.MP4", "GL010002.lrv"}) folder.Write(name, film);
  const Flight flight = Read(folder);
  EXPECT_EQ(flight.films, std::vector<std::string>{"DJI_0001.MP4"});
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("2 films (DJI_0001.LRF first) are not used")));
}

TEST(ReadFlight, KeepsTwoPhotosOfOneNameAndDropsTrueDoubles) {
  const TemporaryFolder folder;
  folder.Write("100/DJI_0001.JPG", PhotoAt(1.0, "2021:06:03 12:00:00"));
  folder.Write("101/DJI_0001.JPG", PhotoAt(1.1, "2021:06:03 12:00:05"));
  folder.Write("copy/DJI_0001.JPG", PhotoAt(1.0, "2021:06:03 12:00:00"));
  const Flight flight = Read(folder);
  EXPECT_EQ(Names(flight), (std::vector<std::string>{"100/DJI_0001.JPG", "101/DJI_0001.JPG"}));
  ASSERT_EQ(flight.left_out.size(), 1u);
  EXPECT_EQ(flight.left_out[0].name, "copy/DJI_0001.JPG");
  EXPECT_THAT(InWords(flight.left_out[0].reason), HasSubstr("DJI_0001.JPG"));
}

// Behind its tags the picture that `content` stands for.
Bytes Showing(std::uint8_t content, Bytes photo = JpegHeader({})) {
  photo[photo.size() - 3] = content;  // before the end marker
  return photo;
}

// A file of the exposure.
Bytes TaggedPhoto(double lat_deg, std::uint32_t error_cm, std::uint8_t content) {
  ExifWriter exif;
  exif.Ascii(ExifIfd::kImage, 0x010F, "DJI").Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 12:00:00");
  if (lat_deg != 0.0) exif.Position(lat_deg, 7.0);
  if (error_cm > 0) exif.Rational(ExifIfd::kGps, 0x1F, {{error_cm, 100}});
  return Showing(content, JpegHeader({.exif = exif.Write()}));
}

// A file beside a photo, at 7 degrees east.
Bytes SidecarAt(const std::string& lat) {
  const std::string xmp =
      XmpPacket("xmlns:exif=\"http://ns.adobe.com/exif/1.0/\" exif:GPSLatitude=\"" + lat +
                "\" exif:GPSLongitude=\"7,0.0E\" exif:GPSAltitude=\"5105/10\" exif:GPSAltitudeRef=\"0\"");
  return {xmp.begin(), xmp.end()};
}

TEST(ReadFlight, UsesOfFilesOfOnePictureTheOneOfTheBestPosition) {
  const TemporaryFolder folder;
  folder.Write("DJI_0001.JPG", TaggedPhoto(1.0, 0, 1));
  folder.Write("PPK/DJI_0001.JPG", TaggedPhoto(1.00001, 2, 1));
  folder.Write("DJI_0002.JPG", TaggedPhoto(0.0, 0, 2));
  folder.Write("geotagged/DJI_0002_geotag.JPG", TaggedPhoto(1.1, 0, 2));
  folder.Write("DJI_0003.JPG", TaggedPhoto(1.2, 0, 3));
  folder.Write("out/DJI_0003_geotag.JPG", TaggedPhoto(1.20001, 0, 3));
  const Flight flight = Read(folder);
  EXPECT_THAT(Names(flight), ::testing::UnorderedElementsAre("PPK/DJI_0001.JPG", "DJI_0002_geotag.JPG",
                                                             "DJI_0003_geotag.JPG"));
  ASSERT_EQ(flight.left_out.size(), 3u);
  std::vector<std::string> reasons;
  for (const LeftOutPhoto& left : flight.left_out) {
    EXPECT_EQ(left.code, ErrorCode::kConflict);
    reasons.push_back(InWords(left.reason));
  }
  EXPECT_THAT(reasons, Contains(HasSubstr("PPK/DJI_0001.JPG")));
}

TEST(ReadFlight, UsesNoPositionInCoarseStepsWhereAFileHasAFineOne) {
  ExifWriter in_tenths;  // of seconds, 3 m
  in_tenths.Ascii(ExifIfd::kImage, 0x010F, "DJI").Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 12:00:00");
  in_tenths.Ascii(ExifIfd::kGps, 1, "N").Ascii(ExifIfd::kGps, 3, "E");
  in_tenths.Rational(ExifIfd::kGps, 2, {{1, 1}, {0, 1}, {1, 10}});
  in_tenths.Rational(ExifIfd::kGps, 4, {{7, 1}, {0, 1}, {1, 10}});
  const TemporaryFolder folder;
  folder.Write("DJI_0001.JPG", TaggedPhoto(1.00003, 0, 1));
  folder.Write("out/DJI_0001_geotag.JPG", Showing(1, JpegHeader({.exif = in_tenths.Write()})));
  EXPECT_EQ(Names(Read(folder)), (std::vector<std::string>{"DJI_0001.JPG"}));
}

TEST(ReadFlight, KeepsPicturesOfARigThatHaveOneNameAndSecond) {
  const TemporaryFolder folder;
  folder.Write("A/DSC_0001.JPG", TaggedPhoto(1.0, 0, 1));
  folder.Write("B/DSC_0001.JPG", TaggedPhoto(1.0, 0, 2));
  folder.Write("C/DSC_0001.JPG", TaggedPhoto(1.0, 0, 3));
  EXPECT_EQ(Read(folder).photos.size(), 3u);
}

TEST(ReadFlight, TakesPositionsOfFilesBesidePhotosThatHaveNone) {
  const TemporaryFolder folder;
  folder.Write("a.JPG", Showing(1));
  folder.Write("a.xmp", SidecarAt("46,30.0N"));
  folder.Write("b.JPG", Showing(2));
  folder.Write("b.JPG.XMP", SidecarAt("46,30.6N"));
  folder.Write("c.JPG", PhotoAt(46.52, ""));
  folder.Write("c.xmp", SidecarAt("10,0.0N"));
  folder.Write("other/d.JPG", Showing(3));
  folder.Write("d.xmp", SidecarAt("10,0.0N"));
  const Flight flight = Read(folder);
  ASSERT_EQ(Names(flight), (std::vector<std::string>{"a.JPG", "b.JPG", "c.JPG", "d.JPG"}));
  ASSERT_TRUE(flight.photos[0].position && flight.photos[1].position);
  EXPECT_NEAR(flight.photos[0].position->position.lat_deg, 46.5, 1e-9);
  EXPECT_EQ(flight.photos[0].position->height_amsl_m, 510.5);
  EXPECT_NEAR(flight.photos[1].position->position.lat_deg, 46.51, 1e-9);
  EXPECT_NEAR(flight.photos[2].position->position.lat_deg, 46.52, 1e-6);
  EXPECT_FALSE(flight.photos[3].position) << "of another folder";
  EXPECT_THAT(InWords(flight.warnings),
              Contains(HasSubstr("2 .xmp files beside photos are not used (c.xmp first)")));
  EXPECT_THAT(InWords(flight.warnings),
              Contains(HasSubstr("2 of 4 photos (a.JPG first): The position is that of")));
}

// As servers have them: in one folder, with the folders that they came from in front of some names.
TEST(ReadFlight, FindsFilesBesidePhotosUnderNamesWithFolders) {
  const TemporaryFolder folder;
  std::vector<InputFile> files;
  const auto add = [&](const std::string& name, const Bytes& bytes) {
    const std::string stored = fmt::format("f{}", files.size());
    folder.Write(stored, bytes);
    files.push_back({name, folder.path() / stored});
  };
  for (const char* name : {"100_DJI_0001.JPG", "101_DJI_0001.JPG", "DJI_0002.JPG", "0003.JPG"})
    add(name, Showing(static_cast<std::uint8_t>(files.size())));
  const char* const beside[] = {"100_DJI_0001.xmp", "101_DJI_0001.xmp", "DJI_0002.xmp", "IMG_0003.xmp"};
  for (int i = 0; i < 4; ++i) add(beside[i], SidecarAt(fmt::format("4{},0.0N", i)));
  SilentProgress progress;
  const auto flight = ValueOf(ReadFlight(files, 0, progress));
  std::map<std::string, double> latitudes;
  for (const Photo& photo : flight.photos)
    if (photo.position) latitudes[photo.name] = std::round(photo.position->position.lat_deg);
  EXPECT_EQ(latitudes, (std::map<std::string, double>{
                           {"100_DJI_0001.JPG", 40.0}, {"101_DJI_0001.JPG", 41.0}, {"DJI_0002.JPG", 42.0}}));
}

TEST(ReadFlight, MakesGivenNamesUnique) {
  const TemporaryFolder folder;
  folder.Write("x", PhotoAt(1.0, "2021:06:03 12:00:00"));
  folder.Write("y", PhotoAt(1.1, "2021:06:03 12:00:05"));
  SilentProgress progress;
  const auto flight =
      ValueOf(ReadFlight({{"a.jpg", folder.path() / "x"}, {"a.jpg", folder.path() / "y"}}, 0, progress));
  EXPECT_EQ(Names(flight), (std::vector<std::string>{"a.jpg", "a(2).jpg"}));
}

TEST(ReadFlight, FailsOnlyWithoutAnyFile) {
  SilentProgress progress;
  EXPECT_FALSE(ReadFlight({}, 0, progress).ok());
  const auto missing = ValueOf(ReadFlight({{"a.jpg", "/nonexistent/a.jpg"}}, 0, progress));
  ASSERT_EQ(missing.left_out.size(), 1u);
  EXPECT_EQ(missing.left_out[0].code, ErrorCode::kNotFound);
}

TEST(ReadFlight, StopsWhenCancelled) {
  class Cancelled final : public Progress {
    void BeginStage(std::string_view) override {}
    void Report(double, std::string_view) override {}
    bool IsCancelled() const override { return true; }
  } progress;
  EXPECT_EQ(ErrorOf(ReadFlight({{"a.jpg", "/nonexistent/a.jpg"}}, 0, progress)).code, ErrorCode::kCancelled);
}

TEST(ListInputFiles, NamesWhatIsMissingAndTakesEachFileOnce) {
  EXPECT_THAT(ErrorOf(ListInputFiles({"/nonexistent/folder"})).message, HasSubstr("/nonexistent/folder"));
  const TemporaryFolder folder;
  folder.Write("a.jpg", PhotoAt(1.0, ""));
  const auto twice = ValueOf(ListInputFiles({folder.path(), folder.path() / "a.jpg"}));
  EXPECT_EQ(twice.size(), 1u);
  const auto relative = folder.path().lexically_relative(std::filesystem::current_path());
  const auto either = ValueOf(ListInputFiles({relative, folder.path()}));
  ASSERT_EQ(either.size(), 1u);
  EXPECT_TRUE(either.front().path.is_absolute()) << either.front().path;
}

TEST(ListInputFiles, PassesOverFoldersOfPrograms) {
  const TemporaryFolder folder;
  folder.Write("DJI_0001.JPG", PhotoAt(1.0, ""));
  for (const char* name : {"@eaDir/DJI_0001.JPG/SYNOPHOTO_THUMB_M.jpg", "$RECYCLE.BIN/a.jpg",
                           "#recycle/b.jpg", ".thumbnails/c.jpg", "__MACOSX/d.jpg"})
    folder.Write(name, PhotoAt(1.1, ""));
  const auto files = ValueOf(ListInputFiles({folder.path()}));
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files.front().name, "DJI_0001.JPG");
}

TEST(ListInputFiles, TellsOfFoldersThatMayNotBeRead) {
  if (geteuid() == 0) GTEST_SKIP() << "who may read everything";
  const TemporaryFolder folder;
  folder.Write("a.jpg", PhotoAt(1.0, ""));
  folder.Write("closed/b.jpg", PhotoAt(1.1, ""));
  const std::filesystem::path closed = folder.path() / "closed";
  std::filesystem::permissions(closed, std::filesystem::perms::none);
  std::vector<std::filesystem::path> denied;
  const auto tells = [&](const std::filesystem::path& path) { denied.push_back(path); };
  const auto files = ListInputFiles({folder.path()}, {}, tells);
  const auto none = ListInputFiles({closed}, {}, tells);
  std::filesystem::permissions(closed, std::filesystem::perms::owner_all);
  EXPECT_EQ(ValueOf(files).size(), 1u);
  EXPECT_TRUE(ValueOf(none).empty());
  EXPECT_EQ(denied, (std::vector<std::filesystem::path>{closed, closed}));
}

TEST(ReadFlight, ListsWhatIsNoFileAtAll) {
  const TemporaryFolder folder;
  folder.Write("a.jpg", PhotoAt(1.0, ""));
  std::filesystem::create_symlink("/nonexistent", folder.path() / "dangling.jpg");
  ASSERT_EQ(::mkfifo((folder.path() / "pipe.jpg").c_str(), 0600), 0);
  const Flight flight = Read(folder);
  ASSERT_EQ(flight.left_out.size(), 2u);
  EXPECT_THAT(InWords(flight.left_out[0].reason), HasSubstr("No such file"));
  EXPECT_THAT(InWords(flight.left_out[1].reason), HasSubstr("no regular file"));
  EXPECT_EQ(flight.photos.size(), 1u);
}

TEST(ReadFlight, SaysWhatItMakesOfFilesBesidePhotos) {
  std::string noise(5000, '\0');
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<char>((i * 2654435761u) >> 13);
  const std::string licence = "Permission is hereby granted, free of charge, to any person\n";
  const std::string table = "time_s,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n";
  struct Case {
    std::map<std::string, std::string> files;
    std::vector<const char*> said;  // one remark holds them all; none: nothing is "Not used"
    std::optional<std::size_t> logs{};
    std::optional<std::vector<std::string>> left_out{};
  };
  const Case cases[] = {
      {{{"00000012.BIN", noise}, {"notes.dat", noise}}, {"00000012.BIN is named like a flight log"}},
      {{{"00000012.BIN", noise}, {"notes.dat", noise}}, {"Not used", "notes.dat"}},
      {{{"ride.fit", std::string("\x0E\x10\x5D\x08\x40\0\0\0.FIT\0\0", 14)}},
       {"ride.fit is a track in the format FIT"},
       {},
       std::vector<std::string>{}},
      {{{"LICENSE", licence}, {"page.jpg", licence}},
       {"Not used", "LICENSE"},
       {},
       std::vector<std::string>{"page.jpg"}},
      {{{"Map_Notes.geojson", R"({"type":"FeatureCollection","features":[]})"}}, {}},
      {{{"gnss.csv", table}, {"copy.csv", table}}, {"gnss.csv is not used: it is the same as copy.csv"}, 1},
      {{{"gcp_list.txt", "EPSG:4326\nnan 46.8 1 10 10 a.jpg p1\n1e300 46.8 1 10 10 a.jpg p1\n"}},
       {"gcp_list.txt"}},
      {{{"gnss.csv",
         "time_s,lat_deg,lon_deg,alt_m\n5,46.8,7.1,500\n1,46.8,7.1,500\n9,46.8,7.1,500\n"
         "2,46.8,7.1,500\n"}},
       {"gnss.csv is not used"},
       0}};
  for (const Case& one : cases) {
    SCOPED_TRACE(one.files.begin()->first);
    const TemporaryFolder folder;
    folder.Write("a.jpg", PhotoAt(1.0, ""));
    for (const auto& [name, content] : one.files) folder.Write(name, content);
    const Flight flight = Read(folder);
    EXPECT_EQ(Names(flight), std::vector<std::string>{"a.jpg"});
    EXPECT_EQ(flight.logs.size(), one.logs.value_or(flight.logs.size()));
    std::vector<std::string> left_out;
    for (const LeftOutPhoto& photo : flight.left_out) left_out.push_back(photo.name);
    EXPECT_EQ(left_out, one.left_out.value_or(left_out));
    if (one.said.empty()) {
      EXPECT_THAT(InWords(flight.warnings), Not(Contains(HasSubstr("Not used"))));
      continue;
    }
    ::testing::Matcher<std::string> said = ::testing::_;
    for (const char* words : one.said) said = ::testing::AllOf(said, HasSubstr(words));
    EXPECT_THAT(InWords(flight.warnings), Contains(said));
  }
}

TEST(ReadFlight, ExplainsATableThatItCannotUseAboveAllElse) {
  const TemporaryFolder folder;
  folder.Write("a.jpg", PhotoAt(1.0, ""));
  folder.Write("track.csv", "stamp,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n");
  folder.Write("letter.txt", "hello");
  const Flight flight = Read(folder);
  ASSERT_GE(flight.warnings.size(), 2u);
  EXPECT_THAT(InWords(flight.warnings[0]), HasSubstr("track.csv is a table, but not used: no column"));
  EXPECT_THAT(InWords(flight.warnings[1]), ::testing::AllOf(HasSubstr("Not used"), HasSubstr("letter.txt")));
}

TEST(ReadFlight, TakesTimesFromNamesWhereNothingElseTellsThem) {
  const TemporaryFolder folder;
  folder.Write("2018080501004480Z.jpg", JpegHeader({}));
  folder.Write("2018080501004230Z.jpg", JpegHeader({.width_px = 4008}));
  const Flight flight = Read(folder);
  ASSERT_EQ(Names(flight), (std::vector<std::string>{"2018080501004230Z.jpg", "2018080501004480Z.jpg"}));
  ASSERT_TRUE(flight.photos[0].captured_at);
  EXPECT_FALSE(flight.photos[0].captured_at_is_local);
  EXPECT_EQ(flight.photos[1].captured_at->time_since_epoch().count() % 60'000'000, 44'800'000);
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("2 of 2 photos carry no time in their metadata")));
}

TEST(ReadFlight, SaysOnceWhatItDoubtedOfSeveralPhotos) {
  const TemporaryFolder folder;
  const auto with_xmp = [](double lat_deg, const std::string& attributes) {
    return JpegHeader({.exif = ExifWriter().Position(lat_deg, 7.0).Write(), .xmp = XmpPacket(attributes)});
  };
  const std::string damaged =
      "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" Camera:IMUAngularVelocity=\"*\" ";
  folder.Write("a.jpg", PhotoAt(1.0, ""));
  folder.Write("b.jpg", with_xmp(1.001, damaged));
  folder.Write("c.jpg", with_xmp(1.002, damaged));
  const Flight flight = Read(folder);
  ASSERT_EQ(flight.photos.size(), 3U);
  const auto of = [&](const char* what) {
    return std::count_if(flight.warnings.begin(), flight.warnings.end(),
                         [&](const Remark& said) { return InWords(said).find(what) != std::string::npos; });
  };
  EXPECT_EQ(of("gyro"), 1);
  EXPECT_THAT(InWords(flight.warnings),
              Contains(HasSubstr("2 of 3 photos (b.jpg first): The gyro's records")));
  EXPECT_EQ(of("focal length"), 1) << "one remark of it, not two";
}

TEST(ReadFlight, KeepsRemarksOnSinglePhotosFew) {
  const TemporaryFolder folder;
  for (int i = 0; i < 40; ++i) {
    folder.Write(fmt::format("{:02}.jpg", i),
                 JpegHeader({.exif = ExifWriter().Position(1.0, 7.0).Write(),
                             .xmp = XmpPacket(fmt::format("drone-dji:GpsLatitude=\"{:.3f}\" "
                                                          "drone-dji:GpsLongitude=\"7.0\" ",
                                                          1.001 + 0.001 * i))}));
  }
  const Flight flight = Read(folder);
  ASSERT_EQ(flight.photos.size(), 40U);
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("EXIF and XMP put the photo")));
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("more remarks like these")));
  EXPECT_LT(flight.warnings.size(), 14U);
}

TEST(LooksLikeFilm, TellsFilmsFromPicturesInTheSameContainer) {
  EXPECT_TRUE(LooksLikeFilm(std::string("\0\0\0\x18", 4) + "ftypmp42"));
  EXPECT_TRUE(LooksLikeFilm(std::string("\0\0\0\x14", 4) + "ftypqt  "));
  for (const char* brand : {"heic", "avif", "avis", "msf1", "hevx", "crx "})
    EXPECT_FALSE(LooksLikeFilm(std::string("\0\0\0\x18", 4) + "ftyp" + brand)) << brand;
  EXPECT_FALSE(LooksLikeFilm("\xff\xd8\xff"));
  EXPECT_FALSE(LooksLikeFilm(""));
}

}  // namespace
}  // namespace skyquilt::flight
