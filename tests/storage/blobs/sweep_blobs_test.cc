#include "storage/folder/object_store/sweep_blobs.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "storage/blobs/blob_store.h"
#include "storage/blobs/folder_blobs.h"
#include "storage/db/ids.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/jobs/unit_queue.h"
#include "tests/storage/blobs/far_folder.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {
namespace {

// A folder stands for the store: what is swept is the same.
class SweptBlobs : public CatalogueFixture {
 protected:
  void Put(const std::string& key) { ASSERT_TRUE(blobs_.Put(key, dir_.Write("file", "x"))); }
  // As if its maps had been made and replaced.
  void GiveOut(std::int64_t revision) {
    ASSERT_TRUE(db_->Lock()->Change("UPDATE flight SET next_revision=?2 WHERE id=?1", flight_, revision + 1));
  }
  bool Has(const std::string& key) { return blobs_.Find(key).ok(); }
  SweepReport Sweep(std::chrono::seconds age) {
    const auto report = SweepBlobs(blobs_, catalogue_, queue_, Now(), age);
    EXPECT_TRUE(report) << report.error().message;
    return *report;
  }

  FolderBlobs blobs_{dir_ / "store"};
  const std::string flight_ = catalogue_.AddFlight("a", "{}", Now())->id;
  const std::string photo_ = NewId();
};

TEST_F(SweptBlobs, KeepsWhatIsShownAndTakesWhatIsNobodys) {
  ASSERT_TRUE(catalogue_.AddFile(flight_, {"a.jpg", photo_, 1}, Now()));
  const std::string stray = NewId(), other_flight = NewId();
  GiveOut(3);
  Put(FilesPrefix(flight_) + photo_);
  Put(FilesPrefix(flight_) + stray);
  Put(RevisionPrefix(flight_, 3) + "mosaic.tif");
  Put(RevisionPrefix(flight_, 3) + "frames/a.jpg");
  Put(FlightPrefix(flight_) + "not-ours");
  Put(FilesPrefix(other_flight) + NewId());
  const SweepReport report = Sweep(std::chrono::seconds(0));
  EXPECT_EQ(report.removed, 2);
  EXPECT_TRUE(Has(FilesPrefix(flight_) + photo_));
  EXPECT_FALSE(Has(FilesPrefix(flight_) + stray));
  EXPECT_TRUE(blobs_.List(RevisionPrefix(flight_, 3))->empty());
  EXPECT_TRUE(Has(FlightPrefix(flight_) + "not-ours"));
  EXPECT_EQ(blobs_.List(FlightPrefix(other_flight))->size(), 1U);  // told of, but kept
  const auto lost = blobs_.List("lost/");
  ASSERT_EQ(lost->size(), 1U);
  EXPECT_TRUE((*lost)[0].key.ends_with(FilesPrefix(flight_) + stray));
  EXPECT_EQ(report.moved.size(), 2U);
  EXPECT_TRUE(blobs_.List("clock/")->empty());
}

TEST_F(SweptBlobs, TakesPartsOfFlightsWhoseJobsHaveEnded) {
  const Lease lease = Begun(flight_, Now());
  ASSERT_TRUE(*UnitQueue(*db_).TakeOver(lease, "made from", Now()));
  const std::string part = FlightPrefix(flight_) + UnitsFolderName(lease.job_id) + "/look-0/found.cbor";
  Put(part);
  EXPECT_EQ(Sweep(std::chrono::seconds(0)).removed, 0);
  ASSERT_TRUE(queue_.Cancel(lease.job_id, Now()));
  ASSERT_TRUE(*queue_.Dismiss(lease, Now()));
  EXPECT_EQ(Sweep(kOrphanAge).removed, 0);
  EXPECT_TRUE(Has(part));
  EXPECT_EQ(Sweep(std::chrono::seconds(0)).removed, 1);
  EXPECT_FALSE(Has(part));
}

TEST_F(SweptBlobs, KeepsPartsOfAJobThatFailedForADayForTheNext) {
  const Lease lease = Begun(flight_, Now());
  UnitQueue units(*db_);
  ASSERT_TRUE(*units.TakeOver(lease, "made from", Now()));
  const std::string part = FlightPrefix(flight_) + UnitsFolderName(lease.job_id) + "/look-0/found.cbor";
  Put(part);
  ASSERT_TRUE(*queue_.Fail(lease, {ErrorCode::kInternal, "it died", ""}, false, Now()));
  EXPECT_EQ(Sweep(std::chrono::seconds(0)).removed, 0);
  EXPECT_TRUE(Has(part));
  const auto later = SweepBlobs(blobs_, catalogue_, queue_, Now() + kUnitsKept + std::chrono::hours(2),
                                std::chrono::seconds(0));
  ASSERT_TRUE(later);
  EXPECT_EQ(later->removed, 1);
  EXPECT_FALSE(Has(part));
}

TEST_F(SweptBlobs, LeavesAloneWhatIsYoung) {
  Put(FilesPrefix(flight_) + photo_);  // put, and the catalogue not told yet
  Put(RevisionPrefix(flight_, 3) + "mosaic.tif");
  EXPECT_EQ(Sweep(kOrphanAge).removed, 0);
  EXPECT_TRUE(Has(FilesPrefix(flight_) + photo_));
  EXPECT_TRUE(Has(RevisionPrefix(flight_, 3) + "mosaic.tif"));
}

TEST_F(SweptBlobs, LeavesRevisionsAloneWhileAJobRuns) {
  GiveOut(3);
  Put(RevisionPrefix(flight_, 3) + "mosaic.tif");
  Begun(flight_, Now());
  EXPECT_EQ(Sweep(std::chrono::seconds(0)).removed, 0);
  EXPECT_TRUE(Has(RevisionPrefix(flight_, 3) + "mosaic.tif"));
  // The worker itself, at the beginning of its job.
  EXPECT_EQ(*SweepRevisionBlobs(blobs_, catalogue_, flight_), 1);
}

// The catalogue is an older copy, or a copied data folder's beside the one that was copied.
TEST_F(SweptBlobs, LeavesAFlightAloneWithAMapThatTheCatalogueNeverMade) {
  GiveOut(2);
  const std::vector<std::string> keys = {FilesPrefix(flight_) + photo_,
                                         RevisionPrefix(flight_, 2) + "mosaic.tif",
                                         RevisionPrefix(flight_, 3) + "mosaic.tif"};
  for (const std::string& key : keys) Put(key);
  const SweepReport report = Sweep(std::chrono::seconds(0));
  EXPECT_EQ(report.removed, 0);
  ASSERT_EQ(report.moved.size(), 1U);
  EXPECT_NE(report.moved[0].find("older copy"), std::string::npos) << report.moved[0];
  Begun(flight_, Now());
  EXPECT_EQ(SweepRevisionBlobs(blobs_, catalogue_, flight_).error().code, ErrorCode::kConflict);
  for (const std::string& key : keys) EXPECT_TRUE(Has(key)) << key;
}

TEST_F(SweptBlobs, EndsADeletionThatWasCutOff) {
  const std::string gone = NewId();
  Put("deleted/" + gone);
  Put(FilesPrefix(gone) + NewId());
  Put(RevisionPrefix(gone, 1) + "mosaic.tif");
  Put("deleted/" + flight_);  // never of a flight that is there
  Put(FilesPrefix(flight_) + photo_);
  ASSERT_TRUE(catalogue_.AddFile(flight_, {"a.jpg", photo_, 1}, Now()));
  Sweep(kOrphanAge);
  EXPECT_TRUE(blobs_.List(FlightPrefix(gone))->empty());
  Sweep(std::chrono::seconds(0));
  EXPECT_FALSE(Has("deleted/" + gone));
  EXPECT_TRUE(Has(FilesPrefix(flight_) + photo_));
}

TEST_F(SweptBlobs, TakesWhatAWorkerPutAfterItsFlightWasDeleted) {
  const std::string job = queue_.Add(flight_, "{}", Now())->id;
  const std::string part = FlightPrefix(flight_) + UnitsFolderName(job) + "/look-0/found.cbor";
  Put(FilesPrefix(flight_) + photo_);
  ASSERT_TRUE(catalogue_.DeleteFlight(flight_));
  ASSERT_TRUE(RemoveFlightBlobs(blobs_, flight_));
  EXPECT_TRUE(blobs_.List(FlightPrefix(flight_))->empty());
  Put(part);
  EXPECT_EQ(Sweep(kOrphanAge).removed, 1);
  EXPECT_FALSE(Has(part));
  Put(part);
  EXPECT_TRUE(Sweep(std::chrono::seconds(0)).moved.empty());
  EXPECT_TRUE(blobs_.List("")->empty());
}

TEST_F(SweptBlobs, AreSweptPastAFlightThatIsDeletedMeanwhile) {
  const std::string other = catalogue_.AddFlight("b", "{}", Now())->id;
  Put(FilesPrefix(flight_) + photo_);
  Put(FilesPrefix(other) + NewId());
  test::FarFolder far(dir_ / "store");
  far.before_list = [&](const std::string& prefix) {
    if (prefix == kDeletedPrefix) {
      EXPECT_TRUE(catalogue_.DeleteFlight(flight_));
    }
  };
  const SweepReport report =
      test::ValueOf(SweepBlobs(far, catalogue_, queue_, Now(), std::chrono::seconds(0)));
  EXPECT_EQ(report.moved.size(), 1U);
  EXPECT_TRUE(Has(FilesPrefix(flight_) + photo_));
}

TEST_F(SweptBlobs, AreOfOneCatalogue) {
  const std::string mine = NewId();
  EXPECT_TRUE(ClaimBlobs(mine, blobs_));
  EXPECT_TRUE(ClaimBlobs(mine, blobs_));
  EXPECT_EQ(ClaimBlobs(NewId(), blobs_).error().code, ErrorCode::kConflict);
}

}  // namespace
}  // namespace skyquilt::storage
