#include "storage/tags/flight_tags.h"

#include <gtest/gtest.h>

namespace skyquilt::storage {
namespace {

using Tags = std::vector<std::string>;

TEST(FlightTags, AreInOrderAndEachOnce) {
  EXPECT_EQ(*CheckedTags({"north", "maize", "north", "Äcker"}), (Tags{"maize", "north", "Äcker"}));
  EXPECT_TRUE(CheckedTags({})->empty());
}

TEST(FlightTags, MayBeAsLongAsTheyMay) {
  std::string longest;
  for (int i = 0; i < 40; ++i) longest += "ä";
  EXPECT_TRUE(CheckedTags({longest}));
  EXPECT_FALSE(CheckedTags({longest + "x"}));
  std::string heavy;
  for (int i = 0; i < 31; ++i) heavy += "\xF0\x9F\x8C\xBD";
  EXPECT_FALSE(CheckedTags({heavy}));
  Tags many;
  for (int i = 0; i < 20; ++i) many.push_back("tag " + std::to_string(i));
  EXPECT_TRUE(CheckedTags(many));
  many.push_back("tag 3");
  EXPECT_TRUE(CheckedTags(many));
  many.push_back("one more");
  EXPECT_EQ(CheckedTags(many).error().code, ErrorCode::kUnprocessable);
}

TEST(FlightTags, OthersAreRefused) {
  for (const char* tag : {"", " maize", "maize ", "a,b", "a\nb", "a\tb", "\x7f", "\r"}) {
    const auto checked = CheckedTags({"good", tag});
    ASSERT_FALSE(checked) << tag;
    EXPECT_EQ(checked.error().code, ErrorCode::kUnprocessable);
  }
  EXPECT_FALSE(CheckedTags({std::string("a\0b", 3)}));
}

TEST(FlightTags, ComeBackFromTheCataloguesText) {
  for (const Tags& tags : {Tags{}, Tags{"maize"}, Tags{"a", "b c", "ö"}})
    EXPECT_EQ(TagsFrom(TagsText(tags)), tags);
  EXPECT_EQ(TagsText({}), "");
  EXPECT_TRUE(TagsFrom("\n\n").empty());
  EXPECT_EQ(TagsFrom("torn"), Tags{"torn"});
}

}  // namespace
}  // namespace skyquilt::storage
