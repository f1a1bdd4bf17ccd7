#include "storage/catalogue/trash.h"

#include <gtest/gtest.h>

#include "storage/catalogue/event_log.h"
#include "storage/catalogue/node_tasks.h"
#include "storage/catalogue/previews.h"
#include "tests/storage/retention/stored_flight.h"

namespace skyquilt::storage {
namespace {

class TrashTest : public StoredFlightTest {
 protected:
  std::vector<std::string> KindsAfter(std::int64_t seq) {
    std::vector<std::string> kinds;
    const auto events = EventLog(*db_).After(seq, {}, 100);
    for (const Event& event : *events) kinds.push_back(event.kind + event.body);
    return kinds;
  }
};

TEST_F(TrashTest, AFlightInTheTrashIsGoneForAllAndComesBackWhole) {
  Publish();
  const std::string job = (*queue_.LatestOf(flight_))->id;
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  EXPECT_EQ(catalogue_.GetFlight(flight_).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(*catalogue_.HasFlight(flight_));
  EXPECT_TRUE(catalogue_.ListFlights(10, std::nullopt)->flights.empty());
  EXPECT_EQ(catalogue_.ChangeFlight(flight_, {.name = "x"}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.ChangeFlight(flight_, {.options = "{}"}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.AddFile(flight_, {"b.jpg", "other", 7}, Now()).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.AddFileUnderFreeName(flight_, {"b.jpg", "other", 7}, Now()).error().code,
            ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.RemoveFile(flight_, "a.jpg").error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(*catalogue_.ActiveRevision(flight_));
  EXPECT_EQ(queue_.Get(job).error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(queue_.List(std::nullopt, 10)->empty());
  EXPECT_EQ(queue_.Add(flight_, "{}", Now()).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(trash_.Put(flight_, Now()).error().code, ErrorCode::kNotFound);
  // What lies on the disk is still known, so that nothing takes it for garbage; and it still counts.
  EXPECT_EQ(*catalogue_.FlightIds(), std::vector<std::string>{flight_});
  EXPECT_EQ(catalogue_.ListFiles(flight_)->size(), 1u);
  EXPECT_EQ(*catalogue_.Revisions(flight_), std::vector<std::int64_t>{1});
  EXPECT_EQ(*catalogue_.BytesOf("owner"), 7);

  const auto listed = *trash_.List();
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].name, "field");
  EXPECT_EQ(listed[0].bytes, 7);
  EXPECT_EQ(listed[0].file_count, 1);

  ASSERT_TRUE(trash_.Restore(flight_));
  EXPECT_EQ(catalogue_.GetFlight(flight_)->name, "field");
  EXPECT_TRUE(*catalogue_.ActiveRevision(flight_));
  EXPECT_EQ(queue_.Get(job)->state, JobState::kSuccessful);
  EXPECT_TRUE(trash_.List()->empty());
  EXPECT_EQ(trash_.Restore(flight_).error().code, ErrorCode::kNotFound);
}

TEST_F(TrashTest, CancelsTheJobOfADeletedFlight) {
  const Job waiting = *queue_.Add(flight_, "{}", Now());
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  EXPECT_FALSE(queue_.Claim("w", Now())->has_value());
  ASSERT_TRUE(trash_.Restore(flight_));
  EXPECT_EQ(queue_.Get(waiting.id)->state, JobState::kDismissed);

  const Job running = *queue_.Add(flight_, "{}", Now());
  const Lease lease = **queue_.Claim("w", Now());
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  EXPECT_EQ(*queue_.LeaseStateOf(lease), LeaseState::kCancelRequested);
  EXPECT_TRUE(*queue_.Dismiss(lease, Now()));
  ASSERT_TRUE(trash_.Restore(flight_));
  EXPECT_EQ(queue_.Get(running.id)->state, JobState::kDismissed);
}

TEST_F(TrashTest, TellsWhatHappened) {
  const std::int64_t before = *EventLog(*db_).Latest();
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  ASSERT_TRUE(trash_.Restore(flight_));
  EXPECT_EQ(KindsAfter(before), (std::vector<std::string>{R"(deleted{"in_trash":true})", "restored{}"}));
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  ASSERT_TRUE(catalogue_.DeleteFlight(flight_));
  EXPECT_EQ(KindsAfter(before), std::vector<std::string>{R"(deleted{"in_trash":false})"});
  EXPECT_TRUE(trash_.List()->empty());
}

TEST_F(TrashTest, DaysCountByTheAgeClock) {
  ASSERT_TRUE(trash_.Put(flight_, Now() + std::chrono::days(400)));  // by a clock that is far ahead
  const Time age = db_->ages().Now();
  EXPECT_TRUE(trash_.DeletedUntil(age - std::chrono::hours(1))->empty());
  EXPECT_EQ(*trash_.DeletedUntil(age), std::vector<std::string>{flight_});
}

TEST_F(TrashTest, WhatWasRestoredIsNotRemovedWithTheOldOnes) {
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  const Time until = db_->ages().Now();
  ASSERT_EQ(trash_.DeletedUntil(until)->size(), 1u);  // and then somebody takes it back
  ASSERT_TRUE(trash_.Restore(flight_));
  EXPECT_EQ(catalogue_.DeleteFlight(flight_, until).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.DeleteFlight(flight_, Time::max()).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.ListFiles(flight_)->size(), 1u);
  // In the trash once more its days begin anew.
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  const Time before = until - std::chrono::hours(1);
  EXPECT_EQ(catalogue_.DeleteFlight(flight_, before).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(catalogue_.DeleteFlight(flight_, Time::max()));
  EXPECT_TRUE(trash_.List()->empty());
}

TEST_F(TrashTest, UploadsWaitForTheirFlight) {
  SpooledUpload wish;
  wish.flight_id = flight_;
  wish.name = "b.jpg";
  wish.length = 3;
  const Time now = db_->ages().Now();
  const SpooledUpload upload = *spool_.Create(wish, now);
  {
    const auto append = *spool_.Begin(upload.id, 0, false, now);
    const std::vector<std::uint8_t> bytes{1, 2};
    ASSERT_TRUE(append->Write(bytes));
    ASSERT_TRUE(append->Commit(now));
  }
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  EXPECT_EQ(spool_.Find(upload.id, now).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(spool_.Create(wish, now).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(spool_.RemoveExpired(now));
  ASSERT_TRUE(trash_.Restore(flight_));
  EXPECT_EQ(spool_.Find(upload.id, now)->offset, 2);
}

TEST_F(TrashTest, NoPreviewIsDrawnOfADeletedFlight) {
  Previews previews(*db_);
  ASSERT_TRUE(previews.Claim(5)->has_value());
  Preview preview;
  preview.flight_id = flight_;
  preview.folder = NewPreviewFolder();
  preview.edition = 1;
  ASSERT_TRUE(*previews.Show(preview));
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  EXPECT_FALSE(*previews.Find(flight_));
  EXPECT_FALSE(previews.Claim(5)->has_value());
  EXPECT_FALSE(*previews.Show(preview));
  ASSERT_TRUE(trash_.Restore(flight_));
  const auto work = previews.Claim(5);
  ASSERT_TRUE(work->has_value());
  EXPECT_EQ((*work)->fresh.size(), 1u);
}

TEST_F(TrashTest, ANodesTaskIsGoneAndItsNameFree) {
  NodeTasks tasks(*db_);
  ASSERT_TRUE(tasks.Add({"uuid", flight_, "[]", 1, true}));
  ASSERT_TRUE(trash_.Put(flight_, Now()));
  EXPECT_EQ(tasks.Find("uuid").error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(tasks.List()->empty());
  const std::string other = catalogue_.AddFlight("other", "{}", Now())->id;
  ASSERT_TRUE(tasks.Add({"uuid", other, "[]", 1, true}));
  EXPECT_EQ(tasks.Find("uuid")->flight_id, other);
  EXPECT_TRUE(trash_.Restore(flight_));
}

}  // namespace
}  // namespace skyquilt::storage
