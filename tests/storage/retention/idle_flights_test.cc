#include "storage/retention/idle_flights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>

#include "storage/catalogue/tokens.h"
#include "storage/jobs/map_exports.h"
#include "tests/storage/data/earlier_versions.h"
#include "tests/storage/retention/stored_flight.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

using std::chrono::days;
using std::chrono::minutes;

constexpr days kKeep{30};

class IdleFlightsTest : public StoredFlightTest {
 protected:
  // The ids of those that are idle on a day, by the AgeClock; shares end by `now`.
  std::vector<std::string> IdleOn(int day, Time now = Now()) {
    const auto idle = idle_.Look(start_ + days(day), now, kKeep);
    EXPECT_TRUE(idle) << idle.error().detail;
    std::vector<std::string> ids;
    for (const IdleFlight& one : *idle) ids.push_back(one.id);
    return ids;
  }
  bool PutOn(int day, Time now = Now()) {
    const auto put = trash_.PutIf(flight_, now, [&](SqlConnection& db) {
      return IdleFlights::IsIdle(db, flight_, start_ + days(day), now, kKeep);
    });
    EXPECT_TRUE(put) << put.error().detail;
    return *put;
  }
  // From this day on, and not on those before.
  void ExpectIdleFrom(int day, std::initializer_list<int> before) {
    for (const int early : before) EXPECT_TRUE(IdleOn(early).empty()) << early;
    EXPECT_EQ(IdleOn(day), std::vector<std::string>{flight_}) << day;
  }
  // Idle on day 30 but for what `change` does on day 20; then idle on day 20 + 30 and not before.
  template <typename Change>
  void ExpectToBeginAnewAfter(const char* what, Change change) {
    SCOPED_TRACE(what);
    ASSERT_TRUE(idle_.Forget());
    IdleOn(0);
    ASSERT_TRUE(IdleOn(19).empty());
    change();
    ExpectIdleFrom(50, {20, 30, 49});
  }

  IdleFlights idle_{*db_};
  Time start_ = db_->ages().Now();
};

TEST_F(IdleFlightsTest, CountsFromTheFirstLookOnHoweverOldAFlightIs) {
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE flight SET created_us=1"));
  EXPECT_FALSE(PutOn(400));  // never looked at
  EXPECT_TRUE(IdleOn(400).empty());
  EXPECT_TRUE(IdleOn(429).empty());
  EXPECT_FALSE(PutOn(429));
  EXPECT_EQ(IdleOn(430), std::vector<std::string>{flight_});
  EXPECT_TRUE(PutOn(430));
  EXPECT_EQ(trash_.List()->size(), 1u);
  EXPECT_TRUE(IdleOn(900).empty());
  EXPECT_EQ(trash_.PutIf("none", Now(), [](SqlConnection&) { return true; }).error().code,
            ErrorCode::kNotFound);
}

TEST_F(IdleFlightsTest, EveryChangeBeginsAnew) {
  ExpectToBeginAnewAfter("name", [&] { ASSERT_TRUE(catalogue_.ChangeFlight(flight_, {.name = "meadow"})); });
  ExpectToBeginAnewAfter(
      "options", [&] { ASSERT_TRUE(catalogue_.ChangeFlight(flight_, {.options = R"({"format":"png"})"})); });
  ExpectToBeginAnewAfter("tags", [&] {
    FlightChange change;
    change.tags = {"maize"};
    ASSERT_TRUE(catalogue_.ChangeFlight(flight_, change));
  });
  ExpectToBeginAnewAfter("file", [&] {
    ASSERT_TRUE(catalogue_.AddFile(flight_, {"map_notes.geojson", "notes1", 9}, Now()));
  });
  ExpectToBeginAnewAfter("file of the same size", [&] {
    ASSERT_TRUE(catalogue_.AddFile(flight_, {"map_notes.geojson", "notes2", 9}, Now() + minutes(5)));
  });
  ExpectToBeginAnewAfter("file gone",
                         [&] { ASSERT_TRUE(catalogue_.RemoveFile(flight_, "map_notes.geojson")); });
  ExpectToBeginAnewAfter("job that ended between two looks", [&] {
    ASSERT_TRUE(*queue_.Fail(Begun(flight_, Now()), {ErrorCode::kUnprocessable, "no", ""}, false, Now()));
  });
  ExpectToBeginAnewAfter("map", [&] { Publish(); });
  ExpectToBeginAnewAfter("restored", [&] {
    ASSERT_TRUE(trash_.Put(flight_, Now()));
    ASSERT_TRUE(trash_.Restore(flight_));
  });
}

TEST_F(IdleFlightsTest, OneThatIsMarkedIsKept) {
  FlightChange change;
  IdleOn(0);
  change.is_kept = true;
  ASSERT_TRUE(catalogue_.ChangeFlight(flight_, change));
  EXPECT_FALSE(PutOn(30));
  EXPECT_TRUE(IdleOn(30).empty());
  EXPECT_TRUE(IdleOn(300).empty());
  change.is_kept = false;
  ASSERT_TRUE(catalogue_.ChangeFlight(flight_, change));
  // Its days begin with the last look that found it marked.
  EXPECT_FALSE(PutOn(329));
  EXPECT_EQ(IdleOn(330), std::vector<std::string>{flight_});
  // Between the look and the transaction.
  change.is_kept = true;
  ASSERT_TRUE(catalogue_.ChangeFlight(flight_, change));
  EXPECT_FALSE(PutOn(331));
}

TEST_F(IdleFlightsTest, AJobThatWaitsOrRunsKeepsItsFlight) {
  IdleOn(0);
  const Job job = *queue_.Add(flight_, "{}", Now());
  EXPECT_TRUE(IdleOn(100).empty());
  EXPECT_TRUE(IdleOn(200).empty());
  const Lease lease = **queue_.Claim("w", Now());
  EXPECT_TRUE(IdleOn(300).empty());
  EXPECT_FALSE(PutOn(300));
  EXPECT_EQ(queue_.Get(job.id)->state, JobState::kRunning);
  ASSERT_TRUE(*queue_.Fail(lease, {ErrorCode::kUnprocessable, "no", ""}, false, Now()));
  ExpectIdleFrom(331, {301});
}

// Between the look that found it idle and the transaction that would put it away.
TEST_F(IdleFlightsTest, WhatBeginsAtTheLastMomentKeepsItsFlight) {
  IdleOn(0);
  ASSERT_EQ(IdleOn(30), std::vector<std::string>{flight_});
  ASSERT_TRUE(queue_.Add(flight_, "{}", Now()));
  EXPECT_FALSE(PutOn(30));
  ASSERT_TRUE(queue_.Claim("w", Now()));
  EXPECT_FALSE(PutOn(30));
  EXPECT_TRUE(catalogue_.GetFlight(flight_));
  const std::string other = catalogue_.AddFlight("other", "{}", Now())->id;
  IdleOn(30);
  ASSERT_EQ(IdleOn(60), std::vector<std::string>{other});
  ASSERT_TRUE(catalogue_.ChangeFlight(other, {.name = "changed"}));
  const auto put = trash_.PutIf(other, Now(), [&](SqlConnection& db) {
    return IdleFlights::IsIdle(db, other, start_ + days(60), Now(), kKeep);
  });
  ASSERT_TRUE(put);
  EXPECT_FALSE(*put);
}

TEST_F(IdleFlightsTest, AnOpenUploadKeepsItsFlight) {
  IdleOn(0);
  SpooledUpload wish;
  wish.flight_id = flight_;
  wish.name = "b.jpg";
  wish.length = 3;
  const SpooledUpload upload = *spool_.Create(wish, start_);
  EXPECT_TRUE(IdleOn(100).empty());
  EXPECT_FALSE(PutOn(100));
  ASSERT_TRUE(spool_.Remove(upload.id, start_));
  ExpectIdleFrom(130, {129});
}

TEST_F(IdleFlightsTest, AnExportKeepsItsFlight) {
  IdleOn(0);
  MapExport wish;
  wish.flight_id = flight_;
  wish.revision = 1;
  wish.request = "{}";
  wish.format = "geotiff";
  ASSERT_TRUE(MapExports(*db_).Add(wish, Now()));
  EXPECT_TRUE(IdleOn(100).empty());
  EXPECT_FALSE(PutOn(100));
  ASSERT_TRUE(db_->Lock()->Exec("DELETE FROM map_export"));
  EXPECT_EQ(IdleOn(130), std::vector<std::string>{flight_});
}

TEST_F(IdleFlightsTest, AShareKeepsItsFlightUntilItEndsAndTheDaysAfter) {
  const Time now = Now();
  Tokens tokens(*db_);
  Token share;
  share.id = "s";
  share.name = "share";
  share.hash = std::string(32, 's');
  share.created = now;
  share.expires = now + days(90);
  share.flight_id = flight_;
  ASSERT_TRUE(tokens.Add(share));
  const std::string other = catalogue_.AddFlight("other", "{}", now)->id;
  IdleOn(0, now);
  EXPECT_EQ(IdleOn(80, now + days(80)), std::vector<std::string>{other});
  EXPECT_FALSE(PutOn(80, now + days(80)));
  // By a clock that is years ahead the share has ended: only its days begin, and end when the clock is right
  // again.
  EXPECT_EQ(IdleOn(81, now + days(4000)), std::vector<std::string>{other});
  EXPECT_FALSE(PutOn(81, now + days(4000)));
  EXPECT_EQ(IdleOn(82, now + days(82)), std::vector<std::string>{other});
  EXPECT_EQ(IdleOn(111, now + days(111)), std::vector<std::string>{other});
  EXPECT_EQ(IdleOn(112, now + days(112)).size(), 2u);
  EXPECT_TRUE(PutOn(112, now + days(112)));
}

TEST_F(IdleFlightsTest, AnAgeThatWentBackMakesNothingIdle) {
  IdleOn(100);
  ExpectIdleFrom(130, {20, 129});
}

TEST_F(IdleFlightsTest, ForgetsAndBeginsAnew) {
  IdleOn(0);
  ASSERT_TRUE(idle_.Forget());
  EXPECT_FALSE(PutOn(30));
  ExpectIdleFrom(60, {30});
}

// As a server of the version before left it.
TEST_F(IdleFlightsTest, ACatalogueOfVersion17GetsItsTable) {
  ASSERT_TRUE(db_->Lock()->Exec(UndoToVersion(17)));
  ASSERT_TRUE(db_->Lock()->Exec(TestsPostgres() ? "UPDATE catalogue_version SET version=17"
                                                : "PRAGMA user_version=17"));
  const auto reopened = test::ValueOf(OpenTestCatalogue(data_.Catalogue()));
  EXPECT_EQ(Catalogue(*reopened).GetFlight(flight_)->name, "field");
  ExpectIdleFrom(30, {0});
}

TEST_F(IdleFlightsTest, DaysOfACatalogueOfVersion18GoOnAsTheyWere) {
  IdleOn(0);
  ASSERT_TRUE(db_->Lock()->Exec(UndoToVersion(18)));
  ASSERT_TRUE(db_->Lock()->Exec(TestsPostgres() ? "UPDATE catalogue_version SET version=18"
                                                : "PRAGMA user_version=18"));
  const auto reopened = test::ValueOf(OpenTestCatalogue(data_.Catalogue()));
  EXPECT_TRUE(Catalogue(*reopened).GetFlight(flight_)->tags.empty());
  EXPECT_FALSE(Catalogue(*reopened).GetFlight(flight_)->is_kept);
  EXPECT_EQ(IdleOn(30), std::vector<std::string>{flight_});
}

TEST_F(IdleFlightsTest, LooksAtMoreFlightsThanItReadsAtATime) {
  std::vector<std::string> all{flight_};
  for (int i = 0; i < 450; ++i) all.push_back(catalogue_.AddFlight("f", "{}", Now())->id);
  std::sort(all.begin(), all.end());
  IdleOn(0);
  ASSERT_TRUE(catalogue_.ChangeFlight(all[300], {.name = "changed"}));
  ASSERT_TRUE(catalogue_.DeleteFlight(all[301]));
  all.erase(all.begin() + 300, all.begin() + 302);
  EXPECT_EQ(IdleOn(30), all);
}

}  // namespace
}  // namespace skyquilt::storage
