// Text for people.
#include "core/base/text/printable.h"

#include <gtest/gtest.h>

#include <cstddef>

namespace skyquilt {
namespace {

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
