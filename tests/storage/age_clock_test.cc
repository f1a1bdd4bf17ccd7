#include "storage/db/age_clock.h"

#include <gtest/gtest.h>

#include "storage/db/catalogue_db.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

using std::chrono::days;
using std::chrono::seconds;

class AgeClockTest : public testing::Test {
 protected:
  std::unique_ptr<CatalogueDb> Open() { return *CatalogueDb::Open(dir_.path() / "catalogue.db"); }
  test::TemporaryFolder dir_;
};

// Within the time that a slow machine takes for a test.
void ExpectNear(Time a, Time b) { EXPECT_LT(std::chrono::abs(a - b), seconds(60)); }

TEST_F(AgeClockTest, StartsWithTheMachinesClockAndIsTheSameForAll) {
  const auto one = Open();
  const auto other = Open();
  ExpectNear(one->ages().Now(), Now());
  const Time before = one->ages().Now();
  const Time seen = other->ages().Now();
  const Time after = one->ages().Now();
  EXPECT_LE(before, seen);
  EXPECT_LE(seen, after);
}

TEST_F(AgeClockTest, GoesOnWhereItStoodWhenTheMachineStartsAgain) {
  const Time stood = Now() - days(30);
  ASSERT_TRUE(
      Open()->Lock()->Exec("UPDATE age_clock SET boot_id='an earlier start', since_boot_us=7, age_us=" +
                           std::to_string(ToUs(stood))));
  // However far the machine's clock has gone meanwhile, or was set.
  ExpectNear(Open()->ages().Now(), stood);
  const auto db = Open();
  ExpectNear(db->ages().Now(), stood);
  ExpectNear(db->ages().OnTheWall(stood + days(2)), Now() + days(2));
}

TEST_F(AgeClockTest, KeepsWhatPassedSinceItWasSaved) {
  const Time stood = Now() - days(30);
  ASSERT_TRUE(Open()->Lock()->Exec("UPDATE age_clock SET boot_id='an earlier start', age_us=" +
                                   std::to_string(ToUs(stood))));
  const Time told = [&] {
    const auto db = Open();
    EXPECT_TRUE(db->SaveAges());
    return db->ages().Now();
  }();
  ASSERT_TRUE(Open()->Lock()->Exec("UPDATE age_clock SET boot_id='that start, too'"));
  EXPECT_GE(Open()->ages().Now() + seconds(1), told);
}

}  // namespace
}  // namespace skyquilt::storage
