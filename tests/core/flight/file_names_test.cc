// Names that tell files of several folders apart, and letters with marks.
#include "core/base/text/file_names.h"

#include <gmock/gmock.h>

#include "core/flight/bytes/composed_letters.h"

namespace skyquilt::flight {
namespace {

using ::testing::ElementsAre;

TEST(NamesApart, LeavesNamesThatNoOtherFolderHas) {
  EXPECT_THAT(
      NamesApart({"DCIM/100MEDIA/DJI_0001.JPG", "DCIM/101MEDIA/DJI_0002.JPG", "geo.txt", "/a/log.bin"}),
      ElementsAre("DJI_0001.JPG", "DJI_0002.JPG", "geo.txt", "log.bin"));
}

TEST(NamesApart, KeepsTheFoldersOfFilesOfOneNameAndOfListsBesideThem) {
  EXPECT_THAT(NamesApart({"/DCIM/100MEDIA/DJI_0001.JPG", "/DCIM/101MEDIA/DJI_0001.JPG",
                          "/DCIM/101MEDIA/DJI_0002.JPG", "/DCIM/101MEDIA/positions.csv", "/DCIM/notes.txt"}),
              ElementsAre("100MEDIA/DJI_0001.JPG", "101MEDIA/DJI_0001.JPG", "DJI_0002.JPG",
                          "101MEDIA/positions.csv", "notes.txt"));
}

TEST(NamesApart, CallsASidecarAsItsPicture) {
  EXPECT_THAT(NamesApart({"100/a.jpg", "101/a.jpg", "101/a.xmp", "101/b.jpg", "101/b.jpg.xmp", "101/c.srt"}),
              ElementsAre("100/a.jpg", "101/a.jpg", "101/a.xmp", "b.jpg", "b.jpg.xmp", "101/c.srt"));
}

TEST(NamesApart, TakesAsManyFoldersAsItNeeds) {
  EXPECT_THAT(NamesApart({"a/100/x.jpg", "b/100/X.JPG", "c/x.jpg", "x.jpg"}),
              ElementsAre("a/100/x.jpg", "b/100/X.JPG", "c/x.jpg", "x.jpg"));
  EXPECT_THAT(NamesApart({"100/x.jpg", "/a/100/x.jpg"}), ElementsAre("100/x.jpg", "a/100/x.jpg"));
}

TEST(NamesApart, NumbersWhatNothingElseTellsApart) {
  EXPECT_THAT(NamesApart({"x.jpg", "x.jpg", "x.jpg", "", "/"}),
              ElementsAre("x.jpg", "x(2).jpg", "x(3).jpg", "", "(2)"));
}

TEST(IsOfPrograms, KnowsHiddenNamesAndFoldersOfSystems) {
  for (const char* name : {".DS_Store", "._a.jpg", "@eaDir", "#recycle", "$RECYCLE.BIN", "__MACOSX"})
    EXPECT_TRUE(IsOfPrograms(name)) << name;
  for (const char* name : {"", "a.jpg", "100MEDIA", "recycle"}) EXPECT_FALSE(IsOfPrograms(name)) << name;
}

TEST(NumberedName, HasItsMarkInFrontOfTheEnding) {
  EXPECT_EQ(NumberedName("a.jpg", "2"), "a(2).jpg");
  EXPECT_EQ(NumberedName(".hidden", "2"), ".hidden(2)");
  EXPECT_EQ(NumberedName("field.1/log", "2"), "field.1/log(2)");
}

TEST(WithComposedLetters, MakesOneCharacterOfALetterAndItsMarks) {
  EXPECT_EQ(WithComposedLetters("Gru\u0308n_A\u030a.jpg"), "Gr\u00fcn_\u00c5.jpg");
  EXPECT_EQ(WithComposedLetters("e\u0302\u0301 \u0438\u0306"), "\u1ebf \u0439") << "two marks; Cyrillic";
  EXPECT_EQ(WithComposedLetters("Gr\u00fcn.jpg"), "Gr\u00fcn.jpg");
  EXPECT_EQ(WithComposedLetters("\u0308q\u0308\u0308"), "\u0308q\u0308\u0308") << "no letter takes these";
  EXPECT_EQ(WithComposedLetters("a\xcc"), "a\xcc");
  EXPECT_EQ(WithComposedLetters("\xff\xcc\x88"), "\xff\xcc\x88");
}

}  // namespace
}  // namespace skyquilt::flight
