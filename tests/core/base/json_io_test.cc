#include "core/base/text/json_io.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/text/printable.h"

namespace skyquilt {
namespace {

TEST(ParseJson, OfWhatIsNoJsonIsDiscardedAndRefusesToBeReadFrom) {
  for (const char* text : {"", "{", "{\"a\":1}x", "nul", "[1,]", "\"\xff\""}) {
    const nlohmann::json value = ParseJson(text);
    EXPECT_TRUE(value.is_discarded()) << text;
    EXPECT_THROW((void)value.at("a"), nlohmann::json::exception) << text;
  }
}

TEST(ParseJson, KeepsTheOrderOfMembersWhereThatIsAskedFor) {
  constexpr const char* kText = R"({"b":1,"a":[true,null,0.1]})";
  EXPECT_EQ(JsonText(ParseOrderedJson(kText)), kText);
  EXPECT_EQ(JsonText(ParseJson(kText)), R"({"a":[true,null,0.1],"b":1})");
}

TEST(ParseJson, ReadsAFileWhereThereIsOne) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "json_io_test.json";
  std::ofstream(path) << "{\"a\":1}\n";
  EXPECT_EQ(ParseJsonFile(path).at("a"), 1);
  std::filesystem::remove(path);
  EXPECT_TRUE(ParseJsonFile(path).is_discarded());
}

TEST(TextIn, IsAbsentWhereThereIsNone) {
  EXPECT_EQ(TextIn(ParseJson(R"({"a":"b","c":1})"), "a"), "b");
  EXPECT_FALSE(TextIn(ParseJson(R"({"a":"b","c":1})"), "c"));
  for (const char* text : {"{}", "[]", "\"a\"", "{"}) EXPECT_FALSE(TextIn(ParseJson(text), "a")) << text;
}

TEST(JsonText, WritesNamesThatAreNotUtf8AndIndents) {
  const nlohmann::json value = {{"name", "DJI_\xff.JPG"}};
  EXPECT_EQ(JsonText(value), "{\"name\":\"DJI_\xef\xbf\xbd.JPG\"}");
  EXPECT_EQ(JsonText(value, 1), "{\n \"name\": \"DJI_\xef\xbf\xbd.JPG\"\n}");
}

// Text for people.

TEST(Counted, HasOneForOneAloneAndManyForTheRest) {
  EXPECT_EQ(Counted(0, "file"), "0 files");
  EXPECT_EQ(Counted(1, "file"), "1 file");
  EXPECT_EQ(Counted(std::size_t{2}, "file"), "2 files");
  EXPECT_EQ(Counted(1, "was", "were"), "1 was");
  EXPECT_EQ(Counted(7, "was", "were"), "7 were");
}

TEST(Printable, LeavesNothingThatSteersATerminal) {
  EXPECT_EQ(Printable("a\x1b[31m\n\xc3\xa4"), "a?[31m?\xc3\xa4");
}

}  // namespace
}  // namespace skyquilt
