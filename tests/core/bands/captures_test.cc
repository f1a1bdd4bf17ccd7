// Photos of single bands to captures, and what stays of a flight without any.
#include "core/bands/captures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <utility>

#include "core/flight/read_flight.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/bands/band_photos.h"
#include "tests/core/flight/flir_photo.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::bands {
namespace {

using test::ValueOf;

class CapturesTest : public testing::Test {
 protected:
  void Add(const std::string& name, const std::string& band, const std::string& more = "",
           const flight::ExifWriter& exif = UsualExif()) {
    // Levels differ, so that no two files are the same.
    folder_.Write(name, BandPhotoBytes("Camera:BandName=\"" + band + "\" " + more, exif, level_++));
  }
  void AddGreenAndNir(std::initializer_list<const char*> captures) {
    for (const char* id : captures) {
      for (const char* band : {"Green", "NIR"})
        Add(fmt::format("{}_{}.TIF", id, band), band, fmt::format("Camera:CaptureUUID=\"{}\"", id));
    }
  }
  flight::Flight Read() {
    SilentProgress progress;
    return ValueOf(flight::ReadFlight(ValueOf(flight::ListInputFiles({folder_.path()})), 2, progress));
  }
  // The flight of the folder, whose bands were set apart.
  std::pair<flight::Flight, Captures> Apart(int threads = 1) {
    flight::Flight flight = Read();
    Captures apart = SetBandsApart(flight, threads);
    return {std::move(flight), std::move(apart)};
  }
  const test::TemporaryFolder folder_;
  std::uint16_t level_ = 20'000;
};

std::vector<std::string> NamesOf(const flight::Flight& flight) {
  std::vector<std::string> names;
  for (const flight::Photo& photo : flight.photos) names.push_back(photo.name);
  return names;
}

TEST_F(CapturesTest, GroupsById) {
  for (const char* id : {"a", "b"}) {
    for (const char* band : {"NIR", "Green", "Red"}) {
      Add(std::string(id) + "_" + band + ".TIF", band,
          fmt::format("Camera:CaptureUUID=\"{}\" Camera:CentralWavelength=\"{}\"", id,
                      band[0] == 'N'   ? 790
                      : band[0] == 'R' ? 660
                                       : 550));
    }
  }
  flight::Flight flight = Read();
  ASSERT_EQ(flight.photos.size(), 6U);
  const Captures apart = SetBandsApart(flight, 2);
  EXPECT_EQ(NamesOf(flight), (std::vector<std::string>{"a_Green.TIF", "b_Green.TIF"}));
  EXPECT_EQ(apart.reference_band, "green");
  ASSERT_EQ(apart.bands.size(), 3U);
  EXPECT_EQ(apart.bands[0].name, "green");
  EXPECT_EQ(apart.bands[1].name, "red");
  EXPECT_EQ(apart.bands[2].name, "nir");
  ASSERT_EQ(apart.captures.size(), 2U);
  for (const Capture& capture : apart.captures) {
    ASSERT_EQ(capture.photos.size(), 3U);
    EXPECT_EQ(capture.photos[0].photo.name, capture.reference);
    EXPECT_EQ(capture.photos[2].facts.name, "nir");
  }
}

TEST_F(CapturesTest, TheReferenceHasTheNamesOfAll) {
  AddGreenAndNir({"SIM_0001", "SIM_0002"});
  flight::Flight flight = Read();
  SetBandsApart(flight, 1);
  ASSERT_EQ(flight.photos.size(), 2U);
  EXPECT_EQ(flight.photos[1].name, "SIM_0002_Green.TIF");
  EXPECT_EQ(flight.photos[1].other_names, (std::vector<std::string>{"SIM_0002_NIR.TIF", "SIM_0002"}));
}

// DJI_0011.TIF and DJI_0012.TIF: what they have in common names no capture.
TEST_F(CapturesTest, TheCounterOfTheBandIsNoEndOfTheCapturesName) {
  Add("DJI_0011.TIF", "Green", "Camera:CaptureUUID=\"a\"");
  Add("DJI_0012.TIF", "NIR", "Camera:CaptureUUID=\"a\"");
  flight::Flight flight = Read();
  SetBandsApart(flight, 1);
  ASSERT_EQ(flight.photos.size(), 1U);
  EXPECT_EQ(flight.photos[0].other_names, (std::vector<std::string>{"DJI_0012.TIF"}));
}

TEST_F(CapturesTest, GroupsByTimeWithoutIds) {
  for (const int second : {0, 5}) {
    for (const char* band : {"Red", "NIR"}) {
      Add(fmt::format("{}_{}.TIF", second, band), band, "",
          UsualExif(fmt::format("2024:06:01 10:00:{:02}", second)));
    }
  }
  const auto [flight, apart] = Apart();
  ASSERT_EQ(apart.captures.size(), 2U);
  EXPECT_EQ(NamesOf(flight), (std::vector<std::string>{"0_Red.TIF", "5_Red.TIF"}));
}

// A folder for each band, and a clock of whole seconds in which two captures fall.
TEST_F(CapturesTest, NamesTellCapturesOfOneSecondApart) {
  for (const char* band : {"Blue", "Green", "NIR"}) {
    for (const int capture : {1, 2}) {
      if (capture == 1 && band[0] == 'N') continue;  // a file is missing
      Add(fmt::format("{}/IMG_{}.tif", band, capture), band);
    }
  }
  const auto [flight, apart] = Apart();
  ASSERT_EQ(apart.captures.size(), 2U);
  EXPECT_TRUE(flight.left_out.empty());
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(apart.captures[i].photos.size(), i + 2);
    for (const BandPhoto& photo : apart.captures[i].photos)
      EXPECT_TRUE(photo.photo.name.ends_with(fmt::format("IMG_{}.tif", i + 1))) << photo.photo.name;
  }
}

TEST_F(CapturesTest, TheCamerasOfARigMayHaveModelsOfTheirOwn) {
  for (const char* band : {"Green", "NIR"}) {
    Add(fmt::format("{}.TIF", band), band, "Camera:RigName=\"Six\" Camera:ImageUniqueID=\"5010\"",
        UsualExif().Ascii(flight::ExifIfd::kImage, 0x0110, band));
  }
  const auto [flight, apart] = Apart();
  ASSERT_EQ(apart.captures.size(), 1U);
  EXPECT_EQ(apart.captures[0].photos.size(), 2U);
}

TEST_F(CapturesTest, BandsWithoutWavelengthsStandAsUsual) {
  for (const char* band : {"Green", "NIR", "Red", "RedEdge", "Other"})
    Add(std::string(band) + ".TIF", band, "Camera:CaptureUUID=\"a\"");
  const auto [flight, apart] = Apart();
  std::vector<std::string> names;
  for (const Band& band : apart.bands) names.push_back(band.name);
  EXPECT_EQ(names, (std::vector<std::string>{"green", "red", "rededge", "nir", "other"}));
}

TEST_F(CapturesTest, TheReferenceIsTheBandOfMostCaptures) {
  for (const char* id : {"a", "b", "c"}) {
    Add(std::string(id) + "_nir.TIF", "NIR", fmt::format("Camera:CaptureUUID=\"{}\"", id));
    if (id[0] != 'c')
      Add(std::string(id) + "_green.TIF", "Green", fmt::format("Camera:CaptureUUID=\"{}\"", id));
  }
  Add("d_green.TIF", "Red", "Camera:CaptureUUID=\"d\"");
  const auto [flight, apart] = Apart();
  EXPECT_EQ(apart.reference_band, "nir");
  EXPECT_EQ(apart.captures.size(), 3U);
  ASSERT_EQ(flight.left_out.size(), 1U);  // a capture without the reference band
  EXPECT_EQ(flight.left_out[0].name, "d_green.TIF");
  EXPECT_NE(InWords(flight.left_out[0].reason).find("nir"), std::string::npos);
}

TEST_F(CapturesTest, PanelsAndWarmthAreLeftOut) {
  for (const char* band : {"Green", "NIR"}) Add(std::string(band) + ".TIF", band, "Camera:CaptureUUID=\"a\"");
  Add("warm.TIF", "LWIR", "Camera:CaptureUUID=\"a\"");
  Add("panel.TIF", "Green", "Camera:CaptureUUID=\"p\" Camera:CalibrationPicture=\"1\"");
  const auto [flight, apart] = Apart();
  EXPECT_EQ(apart.captures.size(), 1U);
  ASSERT_EQ(flight.left_out.size(), 2U);
  EXPECT_EQ(flight.left_out[0].name, "panel.TIF");
  EXPECT_EQ(flight.left_out[1].name, "warm.TIF");
}

TEST_F(CapturesTest, AListTellsWhichShowAPanelUnlessItNamesAll) {
  AddGreenAndNir({"a", "b"});
  folder_.Write("reflectance.csv", "photo,reflectance\nB_nir.tif,0.5\n");
  auto [flight, apart] = Apart();
  EXPECT_EQ(NamesOf(flight), (std::vector<std::string>{"a_Green.TIF"}));
  EXPECT_EQ(apart.panels.size(), 2U) << "the whole capture";
  EXPECT_EQ(flight.left_out.size(), 2U);

  folder_.Write("reflectance.csv", "photo,reflectance\nb_NIR.TIF,0.5\na_NIR.TIF,0.5\n");
  flight = Read();
  EXPECT_TRUE(SetBandsApart(flight, 1).panels.empty());
  EXPECT_EQ(NamesOf(flight).size(), 2U);
  EXPECT_TRUE(flight.left_out.empty());
  ASSERT_FALSE(flight.warnings.empty());
  EXPECT_NE(InWords(flight.warnings.back()).find("Every capture"), std::string::npos);
}

TEST_F(CapturesTest, RowsOnPanelsOfPhotosThatAreNotHereAreTold) {
  AddGreenAndNir({"a", "b"});
  folder_.Write("reflectance.csv",
                "photo,reflectance\nSET\\000\\b_NIR.TIF,0.5\nc_NIR.TIF,0.5\nd_NIR.TIF,0.5\n");
  const auto [flight, apart] = Apart();
  EXPECT_EQ(apart.panels.size(), 2U) << "in a folder that its photo's name lacks";
  const auto told = std::find_if(flight.warnings.begin(), flight.warnings.end(), [](const auto& warning) {
    return warning.code == flight::RemarkCode::kPanelRowsNameNoPhoto;
  });
  ASSERT_NE(told, flight.warnings.end());
  EXPECT_NE(InWords(*told).find("2 rows name none of the photos (the first is c_NIR.TIF)"),
            std::string::npos);
}

TEST_F(CapturesTest, ABandAloneIsAGreyPicture) {
  for (const char* id : {"a", "b"})
    Add(std::string(id) + ".TIF", "Green", fmt::format("Camera:CaptureUUID=\"{}\"", id));
  flight::Flight flight = Read();
  EXPECT_TRUE(SetBandsApart(flight, 1).empty());
  EXPECT_EQ(flight.photos.size(), 2U);
}

constexpr const char* kGain = "xmlns:FLIR=\"http://ns.flir.com/FLIR/1.0/\" FLIR:TLinearGain=\"0.04\" ";

TEST_F(CapturesTest, TemperaturesAloneAreABand) {
  for (const char* name : {"a.TIF", "b.TIF"}) Add(name, "LWIR", kGain);
  Add("unknown.TIF", "LWIR");
  const auto [flight, apart] = Apart(2);
  EXPECT_EQ(NamesOf(flight), (std::vector<std::string>{"a.TIF", "b.TIF"}));
  EXPECT_EQ(apart.reference_band, "lwir");
  ASSERT_EQ(apart.bands.size(), 1U);
  EXPECT_EQ(apart.bands[0].calibration, Calibration::kKelvin);
  EXPECT_EQ(apart.captures.size(), 2U);
  ASSERT_EQ(flight.left_out.size(), 1U);
  EXPECT_NE(InWords(flight.left_out[0].reason).find("TLinearGain"), std::string::npos);
}

TEST_F(CapturesTest, TemperaturesFollowTheirRig) {
  for (const char* id : {"a", "b"}) {
    for (const char* band : {"Blue", "LWIR"}) {
      Add(std::string(id) + "_" + band + ".TIF", band,
          fmt::format("Camera:CaptureUUID=\"{}\" {}", id, band[0] == 'L' ? kGain : ""));
    }
  }
  Add("c_LWIR.TIF", "LWIR", fmt::format("Camera:CaptureUUID=\"c\" {}", kGain));
  const auto [flight, apart] = Apart();
  EXPECT_EQ(apart.reference_band, "blue");  // though more captures have temperatures
  ASSERT_EQ(apart.captures.size(), 2U);
  EXPECT_EQ(apart.captures[0].photos.size(), 2U);
}

TEST_F(CapturesTest, AThermalPictureWithoutTemperaturesStaysAPicture) {
  flight::JpegParts parts;
  for (const char* name : {"a.JPG", "b.JPG"}) {
    parts.exif = UsualExif(name[0] == 'a' ? "2024:06:01 10:00:00" : "2024:06:01 10:00:02").Write();
    folder_.Write(name, flight::WithFlirRecord(flight::JpegHeader(parts), {'F', 'F', 'F', 0}));
  }
  flight::Flight flight = Read();
  EXPECT_TRUE(SetBandsApart(flight, 1).empty());
  EXPECT_EQ(flight.photos.size(), 2U);
  ASSERT_FALSE(flight.warnings.empty());
  EXPECT_NE(InWords(flight.warnings.back()).find("give no temperatures"), std::string::npos);

  // Beside visible pictures it is none of the map's.
  for (const char* name : {"c.JPG", "d.JPG"}) {
    parts.exif = UsualExif(name[0] == 'c' ? "2024:06:01 10:00:00" : "2024:06:01 10:00:02").Write();
    folder_.Write(name, flight::JpegHeader(parts));
  }
  flight = Read();
  EXPECT_TRUE(SetBandsApart(flight, 1).empty());
  EXPECT_EQ(NamesOf(flight), (std::vector<std::string>{"c.JPG", "d.JPG"}));
  EXPECT_EQ(flight.left_out.size(), 2U);

  // What the pictures of a rig say of their bands stays theirs.
  AddGreenAndNir({"e", "f"});
  flight = Read();
  const Captures apart = SetBandsApart(flight, 2);
  ASSERT_EQ(apart.captures.size(), 2U);
  ASSERT_EQ(apart.captures[1].photos.size(), 2U);
  EXPECT_EQ(apart.captures[1].photos[0].photo.name, "f_Green.TIF");
  EXPECT_EQ(apart.captures[1].photos[0].facts.name, "green");
  EXPECT_EQ(apart.captures[1].photos[1].facts.name, "nir");
}

TEST_F(CapturesTest, ABandsValuesMeanTheSameInAllItsPhotos) {
  for (const char* id : {"a", "b", "c"}) {
    Add(std::string(id) + "_green.TIF", "Green", fmt::format("Camera:CaptureUUID=\"{}\"", id));
    Add(std::string(id) + "_nir.TIF", "NIR", fmt::format("Camera:CaptureUUID=\"{}\"", id),
        id[0] == 'b' ? flight::ExifWriter()
                           .Ascii(flight::ExifIfd::kImage, 0x010F, "Maker")
                           .Ascii(flight::ExifIfd::kImage, 0x0110, "Rig")
                     : UsualExif());
  }
  const auto [flight, apart] = Apart();
  ASSERT_EQ(apart.captures.size(), 3U);
  int nirs = 0;
  for (const Capture& capture : apart.captures) nirs += static_cast<int>(capture.photos.size()) - 1;
  EXPECT_EQ(nirs, 2);
  EXPECT_EQ(flight.photos.size(), 3U);
  ASSERT_FALSE(flight.warnings.empty());
  EXPECT_NE(InWords(flight.warnings.back()).find("bands.tif"), std::string::npos);
}

TEST_F(CapturesTest, AFileThatIsGoneIsLeftOut) {
  AddGreenAndNir({"a", "b"});
  flight::Flight flight = Read();
  std::filesystem::remove(folder_ / "b_NIR.TIF");
  ASSERT_EQ(SetBandsApart(flight, 2).captures.size(), 2U);
  ASSERT_EQ(flight.left_out.size(), 1U);
  EXPECT_EQ(flight.left_out[0].name, "b_NIR.TIF");
}

}  // namespace
}  // namespace skyquilt::bands
