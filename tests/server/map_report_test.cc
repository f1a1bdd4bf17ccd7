// The page about a finished map: what it says, and that nothing of others gets into its markup.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/flight/remarks/because.h"
#include "server/reports/map_picture.h"
#include "server/reports/print_pdf.h"
#include "server/reports/report_page.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::server {
namespace {

constexpr const char* kReport =
    R"({"title":"Field <7>","photos":{"total":3,"aligned":2,"pose_only":0,"left_out":1},
  "left_out_photos":[{"name":"<script>alert(1)</script>.jpg","code":"corrupt","reason":"it is \"cut off\" & torn"}],
  "captured":{"first":"2024-06-01T10:00:00Z","last":"2024-06-01T10:09:00Z"},"gsd_m":0.025,"area_m2":25000,
  "bounds":[7.1,46.8,7.2,46.9],"is_placed":true,"quality":{"status":"limited","absolute":{"sigma_m":2.3,"by":"gnss","count":2},
  "relative":{"error_m":0.01,"error_px":0.42,"by":"tie_points","count":90},"limits":[{"kind":"left_out","count":1,"of":3}]},"height_rule":"take-off","warnings":["Mind the <gap>"],
  "alignment":{"residual_rms_px":0.42,"position_residual_m":0.5,"cameras":[{"camera_key":"DJI|FC220"}]}})";

bool Has(const std::string& page, const char* words) { return page.find(words) != std::string::npos; }

TEST(ReportPage, SaysWhatTheReportHasAndEscapesIt) {
  const auto page = test::ValueOf(ReportPage(kReport, std::nullopt, "2026-01-01"));
  for (const char* words :
       {"Field &lt;7&gt;", "3: 2 placed by what they show", "2.50 ha", "2.5 cm", "DJI FC220", "0.42 px",
        "+-2.3 m (1 sigma), by 2 positions of GNSS", "Usable, with limits. 1 of 3 photos was left out",
        "EPSG:3857", "2024-06-01", "&lt;script&gt;alert(1)&lt;/script&gt;.jpg",
        "it is &quot;cut off&quot; &amp; torn", "Mind the &lt;gap&gt;",
        "46.800000, 7.100000 to 46.900000, 7.200000", "Height above ground at first"})
    EXPECT_TRUE(Has(page, words)) << words;
  EXPECT_FALSE(Has(page, "<script"));
  EXPECT_FALSE(Has(page, "not georeferenced"));
  EXPECT_FALSE(Has(page, "adjusted ones"));
}

TEST(ReportPage, HasTheMissOfEachSurveyedPoint) {
  std::string report = kReport;
  const std::string was = R"("alignment":{)";
  report.insert(report.find(was) + was.size(), R"("ground_control":[
    {"name":"<b>1","sightings":4,"is_used":true,"is_check":false,"reason":"","miss_east_m":0.021,"miss_north_m":-0.03,"miss_up_m":-9.97},
    {"name":"p2_check","sightings":3,"is_used":true,"is_check":true,"reason":"","miss_east_m":1.5,"miss_north_m":0.25,"miss_up_m":null},
    {"name":"p3","sightings":1,"is_used":false,"is_check":false,"reason":"is <marked> once","miss_east_m":0,"miss_north_m":0,"miss_up_m":0}],)");
  const auto page = test::ValueOf(ReportPage(report, std::nullopt, ""));
  for (const char* words :
       {"<td>&lt;b&gt;1</td><td>control</td><td>2.1 cm</td><td>-3 cm</td><td>-9.97 m</td><td>4</td>",
        "<td>p2_check</td><td>check</td><td>1.5 m</td><td>25 cm</td><td></td>",
        "<td>p3</td><td>not used</td><td></td><td></td><td></td><td>1</td><td>is &lt;marked&gt; once</td>"})
    EXPECT_TRUE(Has(page, words)) << words;
}

TEST(ReportPage, IsHeadedByTheNameThatTheMapGoesBy) {
  const auto page = test::ValueOf(ReportPage(kReport, std::nullopt, "", "Mill <north>"));
  EXPECT_TRUE(Has(page, "<h1>Mill &lt;north&gt;</h1>"));
  EXPECT_FALSE(Has(page, "Field"));
}

TEST(PrintPdf, SaysWhatKeptItFromPrinting) {
  const test::TemporaryFolder folder;
  std::filesystem::permissions(folder.Write("weasyprint", "#!/bin/sh\nexit 3\n"),
                               std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  const auto printed = PrintPdf(folder / "report.html", folder / "report.pdf", folder / "gone");
  const Error failed = ReportNotPrinted({ErrorCode::kInternal, "weasyprint ended", ""});
  setenv("PATH", "/nonexistent", 1);
  const Error missing = ReportNotPrinted({ErrorCode::kUnavailable, "install one", ""});
  setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(printed);
  EXPECT_EQ(printed.error().code, ErrorCode::kIo) << printed.error().message;
  EXPECT_EQ(flight::WhyOf(failed), flight::Remark(flight::RemarkCode::kReportNotPrinted));
  EXPECT_EQ(flight::WhyOf(missing), flight::Remark(flight::RemarkCode::kExportWithoutPrinter));
  EXPECT_EQ(missing.code, ErrorCode::kUnavailable);
  const Error late = ReportNotPrinted({ErrorCode::kTimeout, "weasyprint took more than 2 minutes.", ""});
  EXPECT_EQ(late.code, ErrorCode::kTimeout);
  EXPECT_EQ(late.message, "weasyprint took more than 2 minutes.");
}

TEST(PrintPdf, GivesABrowserTheAddressOfThePageWhateverItsFolderIsCalled) {
  const test::TemporaryFolder folder;
  std::filesystem::permissions(
      folder.Write(
          "chromium",
          "#!/bin/sh\nfor word in \"$@\"; do case $word in --print-to-pdf=*) pdf=${word#*=};; esac; done\n"
          "echo \"$word\" > \"$pdf\"\n"),
      std::filesystem::perms::owner_all);
  const std::filesystem::path field = folder / "Field #3 50%20";
  std::filesystem::create_directory(field);
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  const auto printed = PrintPdf(field / "report.html", field / "report.pdf", field);
  setenv("PATH", path.c_str(), 1);
  ASSERT_TRUE(printed) << printed.error().message;
  std::ifstream pdf(field / "report.pdf");
  std::string address;
  std::getline(pdf, address);
  EXPECT_TRUE(address.ends_with("/Field%20%233%2050%2520/report.html")) << address;
}

TEST(MapPixels, AreBelievedOnlyWhereTheyAreAsManyAsTheySay) {
  MapPixels pixels;
  pixels.image.width_px = 3;
  pixels.image.height_px = 2;
  for (std::uint8_t i = 0; i < 24; ++i) pixels.image.rgba.push_back(i);
  pixels.pixel_m = 0.1 / 3;
  const auto same = test::ValueOf(ParseMapPixels(ToBytes(pixels)));
  EXPECT_EQ(same.image.rgba, pixels.image.rgba);
  EXPECT_EQ(same.image.width_px, 3);
  EXPECT_EQ(same.image.height_px, 2);
  EXPECT_EQ(same.pixel_m, pixels.pixel_m);
  const MapPicture picture = EncodeMapPicture(same);
  EXPECT_EQ(std::string(picture.webp.begin(), picture.webp.begin() + 4), "RIFF");
  EXPECT_EQ(picture.width_px, 3);
  const std::string rgba(24, 'x');
  for (const std::string& bad : std::initializer_list<std::string>{
           "", "3 2 0.1" + rgba, "3 2 0.1\n", "3 2 0.1\n" + rgba + "x", "3 2 0.1\n" + rgba.substr(1),
           "2 2 0.1\n" + rgba, "-3 -2 0.1\n" + rgba, "0 2 0.1\n", "3 9999999 0.1\n" + rgba, "3 2 -1\n" + rgba,
           "3 2 nan\n" + rgba, "3 2\n" + rgba, std::string(200, '1') + " 2 0.1\n" + rgba})
    EXPECT_FALSE(ParseMapPixels(bad).ok()) << bad;
}

TEST(ReportPage, HasAScaleBarAndANorthArrowOnlyWhereTheyAreTrue) {
  const MapPicture picture{{1, 2, 3}, 1000, 500, 0.5};
  const auto placed = test::ValueOf(ReportPage(kReport, picture, ""));
  EXPECT_TRUE(Has(placed, "data:image/webp;base64,AQID"));
  EXPECT_TRUE(Has(placed, ">100 m</text>"));  // of 500 m that are shown
  EXPECT_TRUE(Has(placed, ">N</text>"));
  const auto unplaced = test::ValueOf(ReportPage(R"({"is_placed":false})", picture, ""));
  EXPECT_TRUE(Has(unplaced, "not georeferenced"));
  EXPECT_FALSE(Has(unplaced, ">N</text>"));
  EXPECT_FALSE(Has(unplaced, " m</text>"));
}

TEST(ReportPage, SaysNoSizeAndNoAccuracyOfAMapWithoutScale) {
  std::string report = kReport;
  const std::string was = R"("limits":[)";
  report.insert(report.find(was) + was.size(), R"({"kind":"scale_guessed","count":0,"of":0},)");
  const std::string sigma = R"("sigma_m":2.3,"by":"gnss","count":2)";
  report.replace(report.find(sigma), sigma.size(), R"("sigma_m":null,"by":"none","count":0)");
  const auto page = test::ValueOf(ReportPage(report, std::nullopt, ""));
  EXPECT_TRUE(Has(page, "unknown: no positions"));
  EXPECT_TRUE(Has(page, "unknown: the scale is a guess"));
  EXPECT_FALSE(Has(page, "1 sigma"));
  EXPECT_FALSE(Has(page, "2.50 ha"));
}

TEST(ReportPage, SaysThatTheAccuracyIsNotKnownWhereNothingJudgedIt) {
  const auto page = test::ValueOf(ReportPage(R"({"title":"Old","photos":{"total":3}})", std::nullopt, ""));
  EXPECT_TRUE(Has(page, "Accuracy not known."));
}

TEST(ReportPage, TakesAnyJsonAndRefusesTheRest) {
  for (
      const char* text :
      {"{}",
       R"({"photos":[],"bounds":"x","alignment":7,"warnings":{"a":1},"quality":{"status":7},"left_out_photos":[1,null]})",
       R"({"title":5,"captured":{"first":"x"},"bounds":[1,2,3,"4"],"alignment":{"cameras":[3]}})"})
    EXPECT_TRUE(ReportPage(text, std::nullopt, "").ok()) << text;
  for (const char* text : {"", "[]", "{\"a\":"})
    EXPECT_FALSE(ReportPage(text, std::nullopt, "").ok()) << text;
}

TEST(ScaleBarM, IsOneTwoOrFive) {
  EXPECT_EQ(ScaleBarM(140.0), 100.0);
  EXPECT_EQ(ScaleBarM(200.0), 200.0);
  EXPECT_EQ(ScaleBarM(999.0), 500.0);
  EXPECT_NEAR(ScaleBarM(0.3), 0.2, 1e-12);
  EXPECT_EQ(ScaleBarM(0.0), 1.0);
}

}  // namespace
}  // namespace skyquilt::server
