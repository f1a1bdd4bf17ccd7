// Cells of lists as people write them: numbers, coordinates, fields in quotes.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/coordinate_cell.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/logs/texts/list_rows.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

constexpr double kLat = 46.0 + 50.0 / 60.0 + 33.39 / 3600.0;

TEST(ReadCoordinateCell, ReadsEveryWayAnglesAreWritten) {
  for (const char* cell : {"46\xC2\xB0"
                           "50'33.39\"",
                           "46\xB0"
                           "50'33.39\"",
                           "46\xC2\xBA"
                           "50\xE2\x80\xB2"
                           "33,39\xE2\x80\xB3",
                           "46 50 33.39", "46:50:33.39", "46d50m33.39s", "46 deg 50' 33.39\"",
                           "46 deg 50' 33.39\"\"", "\"46\xC2\xB0 50' 33.39''\"",
                           "46\xC2\xB0"
                           "50.5565'",
                           "46 50.5565", "+46 50 33.39",
                           "46\xC3\x82\xC2\xB0"
                           "50\xE2\x80\x99"
                           "33.39\xE2\x80\x9D",
                           "46\xC2\xB0\xC2\xA0"
                           "50\xC2\xB4"
                           "33.39''",
                           "46\xEF\xBF\xBD"
                           "50'33.39\""}) {
    const auto read = ReadCoordinateCell(cell);
    ASSERT_TRUE(read) << cell;
    EXPECT_NEAR(read->value, kLat, 1e-9) << cell;
    EXPECT_EQ(read->hemisphere, 0) << cell;
  }
}

TEST(ReadCoordinateCell, AppliesHemispheresAndSigns) {
  struct Case {
    const char* cell;
    double value;
    char hemisphere;
  };
  for (const Case& c : {Case{"46.8426", 46.8426, 0},
                        Case{"46,8426", 46.8426, 0},
                        Case{"-91.99", -91.99, 0},
                        Case{"\xE2\x88\x92"
                             "91.99",
                             -91.99, 0},
                        Case{"N46.8426", 46.8426, 'N'},
                        Case{"46.8426N", 46.8426, 'N'},
                        Case{"n 46,8426", 46.8426, 'N'},
                        Case{"92.0W", -92.0, 'W'},
                        Case{"W92.0", -92.0, 'W'},
                        Case{"-92.0 W", -92.0, 'W'},
                        Case{"92.0 West", -92.0, 'W'},
                        Case{"33.5 S", -33.5, 'S'},
                        Case{"33.5 S\xC3\xBC"
                             "d",
                             -33.5, 'S'},
                        Case{"8.006 E", 8.006, 'E'},
                        Case{"8,006\xC2\xB0 Ost", 8.006, 'E'},
                        Case{"46.84\xC2\xB0", 46.84, 0},
                        Case{"W91\xC2\xB0"
                             "59'40.42\"",
                             -(91 + 59 / 60.0 + 40.42 / 3600), 'W'},
                        Case{"-0\xC2\xB0"
                             "30'",
                             -0.5, 0},
                        Case{"33d30m0sS", -33.5, 'S'},
                        Case{"576667.108", 576667.108, 0},
                        Case{"5 188 164,607", 5188164.607, 0},
                        Case{"'46.8426", 46.8426, 0},
                        Case{"\"46.8426\"", 46.8426, 0},
                        Case{"468426070", 468426070, 0}}) {
    const auto read = ReadCoordinateCell(c.cell);
    ASSERT_TRUE(read) << c.cell;
    EXPECT_NEAR(read->value, c.value, 1e-9) << c.cell;
    EXPECT_EQ(read->hemisphere, c.hemisphere) << c.cell;
  }
}

TEST(ReadCoordinateCell, RefusesWhatIsNoneOrCouldBeTwo) {
  for (const char* cell : {"",
                           " ",
                           "N",
                           "\xC2\xB0",
                           "nan",
                           "46.84.26",
                           "46\xC2\xB0"
                           "60'00\"",
                           "46\xC2\xB0"
                           "50'60\"",
                           "46 70 10",
                           "46.5\xC2\xB0"
                           "50'",
                           "50'33\"",
                           "N46.8 N",
                           "N46.8 S",
                           "-46.8 N",
                           "46-50-33",
                           "8.006 O",
                           "46 50 33 12",
                           "46d50m33S",
                           "DJI_0018.JPG",
                           "46.84, -91.99",
                           "--46",
                           "46\xC2\xB0\xC2\xB0",
                           "400 10 10"}) {
    EXPECT_FALSE(ReadCoordinateCell(cell)) << cell;
  }
  EXPECT_FALSE(ReadCoordinateCell(std::string(100'000, '1')));
}

TEST(ReadNumber, TellsDecimalMarksFromThousands) {
  struct Case {
    const char* cell;
    DecimalMark mark;
    double value;
  };
  using D = DecimalMark;
  for (const Case& c :
       {Case{"198.309", D::kUnknown, 198.309}, Case{"198,309", D::kUnknown, 198.309},
        Case{"1,234", D::kPoint, 1234}, Case{"1.234", D::kComma, 1234}, Case{"1.234", D::kPoint, 1.234},
        Case{"1,234.5", D::kUnknown, 1234.5}, Case{"1.234,5", D::kUnknown, 1234.5},
        Case{"1'234.5", D::kUnknown, 1234.5}, Case{"1 234,5", D::kUnknown, 1234.5},
        Case{"1\xE2\x80\xAF"
             "234,5",
             D::kUnknown, 1234.5},
        Case{"1,234,567", D::kUnknown, 1234567}, Case{"1.234.567", D::kUnknown, 1234567},
        Case{"0,123", D::kPoint, 0.123}, Case{"46,84", D::kPoint, 46.84}, Case{"-12,5", D::kComma, -12.5},
        Case{"12", D::kUnclear, 12}, Case{"12.5", D::kUnclear, 12.5}, Case{"-1e-3", D::kUnknown, -1e-3}}) {
    const auto read = ReadNumber(c.cell, c.mark);
    ASSERT_TRUE(read) << c.cell;
    EXPECT_NEAR(read->value, c.value, 1e-9) << c.cell;
    EXPECT_TRUE(read->unit.empty()) << c.cell;
  }
  for (const char* cell :
       {"", "abc", "1,2,3", "1.23.456", "1,23,456.7", "2016-06-23", "1.2,3.4", "12 34", "+", ","})
    EXPECT_FALSE(ReadNumber(cell)) << cell;
  EXPECT_FALSE(ReadNumber("1,234", D::kUnclear));
  EXPECT_EQ(EvidenceOfMark("1,234"), MarkEvidence::kLoneComma);
  EXPECT_EQ(EvidenceOfMark("46,84"), MarkEvidence::kComma);
  EXPECT_EQ(EvidenceOfMark("1,234.5"), MarkEvidence::kPoint);
  EXPECT_EQ(EvidenceOfMark("1,234,567"), MarkEvidence::kPoint);
  EXPECT_EQ(EvidenceOfMark("12"), MarkEvidence::kNone);
}

TEST(ReadNumberCell, BringsLengthsToMetres) {
  EXPECT_NEAR(*ReadNumberCell("650.62 ft"), 198.309, 1e-3);
  EXPECT_NEAR(*ReadNumberCell("650,62ft"), 198.309, 1e-3);
  EXPECT_DOUBLE_EQ(*ReadNumberCell("198.3m"), 198.3);
  EXPECT_DOUBLE_EQ(*ReadNumberCell("198.3 m Above Sea Level"), 198.3);
  EXPECT_DOUBLE_EQ(*ReadNumberCell("2 m Below Sea Level"), -2.0);
  EXPECT_DOUBLE_EQ(*ReadNumberCell("45\xC2\xB0"), 45.0);
  for (const char* cell : {"12 apples", "12 rad", "12 m/s", "12 m above the tree"})
    EXPECT_FALSE(ReadNumberCell(cell));
}

TEST(SplitFields, TakesQuotesAroundFieldsAndLeavesThoseInside) {
  const auto fields = [](std::string_view line, char separator) {
    std::vector<std::string_view> cells;
    SplitFields(line, separator, cells);
    return std::vector<std::string>(cells.begin(), cells.end());
  };
  using Fields = std::vector<std::string>;
  EXPECT_EQ(fields("a;46'33.39\";91'40.42\";1", ';'), (Fields{"a", "46'33.39\"", "91'40.42\"", "1"}));
  EXPECT_EQ(fields("\"46,84\", \"x, y\" ,2", ','), (Fields{"46,84", "x, y", "2"}));
  EXPECT_EQ(fields("a,\"46 deg 50' 33.39\"\" N\",b", ','), (Fields{"a", "46 deg 50' 33.39\"\" N", "b"}));
  EXPECT_EQ(fields("\"\",,\"", ','), (Fields{"", "", "\""}));
  EXPECT_EQ(fields("\"a,b,c", ','), (Fields{"\"a", "b", "c"}));
  EXPECT_EQ(fields("a|b||c", '|'), (Fields{"a", "b", "", "c"}));
  EXPECT_EQ(fields("a  b c", ' '), (Fields{"a", "b", "c"}));
  EXPECT_EQ(GuessSeparator("image|latitude|longitude"), '|');
  EXPECT_EQ(GuessSeparator("image;Latitude (deg, WGS84, north)"), ';');
  std::string endless;
  for (int i = 0; i < 200'000; ++i) endless += "\"a,";
  EXPECT_EQ(fields(endless, ',').size(), 1024u) << "and at once";
}

// What stands above the rows of a list: systems and names of columns, in the words that tables use too.

using Columns = std::vector<std::string_view>;

bool IsImageAndTwoNumbers(const Columns& cells) {
  return cells.size() >= 3 && LooksLikeImageName(cells[0]) && ParseListCoordinate(cells[1]) &&
         ParseListCoordinate(cells[2]);
}

TEST(OrderOfColumns, KnowsTheNamesThatTablesKnow) {
  for (const Columns& north_first :
       {Columns{"image", "Latitude (deg)", "Longitude (deg)"}, Columns{"bild", "Breite", "Länge"},
        Columns{"name", "Hochwert", "Rechtswert"}, Columns{"photo", "lat_deg", "lonDeg"},
        Columns{"nombre", "latitud", "longitud"}, Columns{"file", "N", "E"}}) {
    EXPECT_EQ(OrderOfColumns(north_first), NamedOrder::kNorthFirst) << north_first[1];
  }
  for (const Columns& east_first :
       {Columns{"image", "lng", "lat"}, Columns{"punkt", "Rechtswert", "Hochwert", "Höhe"},
        Columns{"name", "Easting (m)", "Northing (m)"}, Columns{"id", "GeoX", "GeoY"},
        Columns{"Longitude_WGS84", "Latitude_WGS84"}}) {
    EXPECT_EQ(OrderOfColumns(east_first), NamedOrder::kEastFirst) << east_first[1];
  }
}

TEST(OrderOfColumns, TellsNothingFromNamesThatSayNoOrder) {
  for (const Columns& open :
       {Columns{"image", "x", "y", "z"}, Columns{"WGS84", "UTM", "15N"}, Columns{"32N", "12E"},
        Columns{"image", "latitude"}, Columns{"heading", "speed"}, Columns{}}) {
    EXPECT_EQ(OrderOfColumns(open), std::nullopt);
  }
}

TEST(ReadListTop, KeepsSystemsAndNamesOfColumnsApart) {
  for (const std::string_view system : {"WGS84 UTM 32N", "ETRS89 / UTM zone 32N", "EPSG:25832+7837",
                                        "wgs84 utm zone 32 north", "+proj=utm +zone=32 +datum=WGS84"}) {
    const std::string text =
        std::string(system) + "\nbild rechtswert hochwert höhe\nDJI_1.JPG 400000 5200000 500\n";
    const auto top = test::ValueOf(ReadListTop(text, IsImageAndTwoNumbers));
    EXPECT_EQ(top.system, system);
    ASSERT_EQ(top.columns.size(), 4u) << system;
    EXPECT_TRUE(top.skipped_lines.empty());
  }
  std::string long_line(200'000, 'n');
  for (std::size_t i = 1; i < long_line.size(); i += 2) long_line[i] = ' ';
  const std::string odd = long_line + "\nDJI_1.JPG 400000 5200000 500\n";
  const auto top = test::ValueOf(ReadListTop(odd, IsImageAndTwoNumbers));
  EXPECT_TRUE(top.columns.empty()) << "nobody names columns so";
}

TEST(NamedLists, TakeTheOrderOfColumnsInOtherLanguages) {
  const std::string text = "bild breite länge höhe\nDJI_1.JPG 46.84 8.1 500\n";
  const auto log = test::ValueOf(ParseLog("positionen.txt", BytesOf(text)));
  ASSERT_EQ(log.events.size(), 1u);
  EXPECT_DOUBLE_EQ(log.events[0].written->x, 8.1);
  EXPECT_DOUBLE_EQ(log.events[0].written->y, 46.84);
  EXPECT_TRUE(log.written_order_is_named);
}

}  // namespace
}  // namespace skyquilt::flight
