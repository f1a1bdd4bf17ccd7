#include "storage/catalogue/catalogue.h"

#include <algorithm>
#include <tuple>

#include "storage/catalogue/trash.h"
#include "storage/catalogue/webhooks.h"
#include "storage/db/ids.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {
namespace {

class CatalogueTest : public CatalogueFixture {
 protected:
  // All flights of a tag, or all, page by page.
  std::vector<std::string> Listed(const std::optional<std::string>& tag = {}) {
    std::vector<std::string> ids;
    std::optional<std::string> cursor;
    do {
      const auto page = test::ValueOf(catalogue_.ListFlights(3, cursor, tag));
      for (const Flight& flight : page.flights) ids.push_back(flight.id);
      cursor = page.next_cursor;
    } while (cursor);
    return ids;
  }
};

TEST_F(CatalogueTest, RemembersAFlightAcrossOpenings) {
  const std::string id = catalogue_.AddFlight("'; DROP TABLE flight; --", "{\"gsd_m\":0.1}", Now())->id;
  ASSERT_TRUE(catalogue_.AddFile(id, {"a.jpg", NewId(), 100}, Now()));
  const auto again = *OpenTestCatalogue(dir_.path() / "catalogue.db");
  const auto flight = test::ValueOf(Catalogue(*again).GetFlight(id));
  EXPECT_EQ(std::tie(flight.name, flight.options, flight.file_count, flight.bytes),
            std::tuple("'; DROP TABLE flight; --", "{\"gsd_m\":0.1}", 1, 100));
  EXPECT_FALSE(flight.active_revision);
}

TEST_F(CatalogueTest, PagesThroughAllFlightsOnceNewestFirst) {
  std::vector<std::string> made;
  for (int i = 0; i < 7; ++i) made.push_back(catalogue_.AddFlight("f", "{}", Now())->id);
  std::sort(made.rbegin(), made.rend());
  EXPECT_EQ(Listed(), made);
}

TEST_F(CatalogueTest, ChangesWhatIsSaidAndNothingElse) {
  FlightChange marks;
  marks.tags = {"maize", "north"};
  const std::string id = catalogue_.AddFlight("field", "{}", Now(), "", marks)->id;
  EXPECT_EQ(catalogue_.GetFlight(id)->tags, *marks.tags);
  EXPECT_FALSE(catalogue_.GetFlight(id)->is_kept);
  FlightChange keep;
  keep.is_kept = true;
  ASSERT_TRUE(catalogue_.ChangeFlight(id, keep));
  ASSERT_TRUE(catalogue_.ChangeFlight(id, {.name = "meadow"}));
  ASSERT_TRUE(catalogue_.ChangeFlight(id, {.options = R"({"quality":80})"}));
  const Flight changed = *catalogue_.GetFlight(id);
  EXPECT_EQ(std::tie(changed.name, changed.options, changed.tags, changed.is_kept),
            std::tuple("meadow", R"({"quality":80})", *marks.tags, true));
  FlightChange longer;  // than a string that needs no memory of its own
  longer.tags = {"farm 3 north of the river", "maize"};
  ASSERT_TRUE(catalogue_.ChangeFlight(id, longer));
  EXPECT_EQ(catalogue_.GetFlight(id)->tags, *longer.tags);
  EXPECT_EQ(catalogue_.ListFlights(3, {}, longer.tags->front())->flights.size(), 1u);
  FlightChange none;
  none.tags.emplace();
  none.is_kept = false;
  ASSERT_TRUE(catalogue_.ChangeFlight(id, none));
  EXPECT_TRUE(catalogue_.GetFlight(id)->tags.empty());
  EXPECT_FALSE(catalogue_.GetFlight(id)->is_kept);
  EXPECT_EQ(catalogue_.ChangeFlight("01", keep).error().code, ErrorCode::kNotFound);
}

TEST_F(CatalogueTest, PagesThroughTheFlightsOfATag) {
  const auto add = [&](std::vector<std::string> tags) {
    FlightChange marks;
    marks.tags = std::move(tags);
    return catalogue_.AddFlight("f", "{}", Now(), "", marks)->id;
  };
  std::vector<std::string> maize;
  for (int i = 0; i < 4; ++i) {
    maize.push_back(add({"maize"}));
    add({"maize, late", "mai"});
    add({"Maize", "sweet maize"});
    add({});
  }
  std::sort(maize.rbegin(), maize.rend());
  EXPECT_EQ(Listed("maize"), maize);
  EXPECT_TRUE(catalogue_.ListFlights(3, {}, "%")->flights.empty());
}

TEST_F(CatalogueTest, PagesThroughMapsWithWhatTheySay) {
  std::vector<std::string> with_map;
  for (int i = 0; i < 5; ++i) {
    const std::string id = catalogue_.AddFlight("field", "{}", Now())->id;
    if (i == 2) continue;  // nothing finished yet
    Revision revision;
    revision.bounds = {1.0 * i, 2.0, 3.0 + i, 4.0};
    revision.first_capture = "2024-06-01T10:00:00+02:00";
    PublishMap(id, revision);
    with_map.insert(with_map.begin(), id);
  }
  ASSERT_TRUE(Trash(*db_).Put(with_map[1], Now()));
  with_map.erase(with_map.begin() + 1);
  std::vector<std::string> listed;
  std::optional<std::string> cursor;
  do {
    const auto page = test::ValueOf(catalogue_.ListMaps(2, cursor));
    for (const ShownFlight& map : page.maps) {
      listed.push_back(map.flight_id);
      EXPECT_EQ(map.name, "field");
      EXPECT_EQ(map.revision.bounds, (*catalogue_.ActiveRevision(map.flight_id))->bounds);
      EXPECT_EQ(map.revision.first_capture, "2024-06-01T10:00:00+02:00");
    }
    cursor = page.next_cursor;
  } while (cursor);
  EXPECT_EQ(listed, with_map);
}

TEST_F(CatalogueTest, ReplacesAFileOfTheSameNameAndSaysWhichBytesToDrop) {
  const std::string id = catalogue_.AddFlight("f", "{}", Now())->id;
  const std::string old_name = NewId();
  EXPECT_FALSE(catalogue_.AddFile(id, {"a.jpg", old_name, 1}, Now())->replaced);
  const auto second = catalogue_.AddFile(id, {"a.jpg", NewId(), 2}, Now());
  EXPECT_TRUE(second->replaced);
  EXPECT_EQ(second->replaced_stored_name, old_name);
  EXPECT_EQ(second->replaced_bytes, 1);
  ASSERT_EQ(catalogue_.ListFiles(id)->size(), 1u);
  EXPECT_EQ(catalogue_.FindFile(id, "a.jpg")->value().bytes, 2);
  EXPECT_FALSE(catalogue_.FindFile(id, "A.jpg")->has_value());
  EXPECT_FALSE(catalogue_.FindFile("x", "a.jpg")->has_value());
}

TEST_F(CatalogueTest, KeepsBothFilesOfOneNameWhenAsked) {
  const std::string id = catalogue_.AddFlight("f", "{}", Now())->id;
  EXPECT_EQ(catalogue_.AddFileUnderFreeName(id, {"a.jpg", NewId(), 1}, Now())->name, "a.jpg");
  EXPECT_EQ(catalogue_.AddFileUnderFreeName(id, {"a.jpg", NewId(), 1}, Now())->name, "a(2).jpg");
  EXPECT_EQ(catalogue_.AddFileUnderFreeName(id, {"a.jpg", NewId(), 1}, Now())->name, "a(3).jpg");
  EXPECT_EQ(catalogue_.AddFileUnderFreeName(id, {".hidden", NewId(), 1}, Now())->name, ".hidden");
  EXPECT_EQ(catalogue_.AddFileUnderFreeName(id, {".hidden", NewId(), 1}, Now())->name, ".hidden(2)");
}

TEST_F(CatalogueTest, RecordsNoFileOfAnUploadThatWasFinishedMeanwhile) {
  const DataDir data = *DataDir::Open(dir_.path() / "data");
  Catalogue recorded(*db_, FlightRecords(data));
  const std::string id = recorded.AddFlight("f", "{}", Now())->id;
  EXPECT_EQ(recorded.AddFileUnderFreeName(id, {"a.jpg", NewId(), 1}, Now(), NewId()).error().code,
            ErrorCode::kConflict);
  EXPECT_TRUE((*ReadFlightRecord(data.Flight(id)))->files.empty());
  EXPECT_TRUE(recorded.ListFiles(id)->empty());
}

TEST_F(CatalogueTest, RefusesToChangeFilesThatAJobReads) {
  const std::string id = catalogue_.AddFlight("f", "{}", Now())->id;
  ASSERT_TRUE(catalogue_.AddFile(id, {"a.jpg", NewId(), 1}, Now()));
  ASSERT_TRUE(queue_.Add(id, "{}", Now()));
  ASSERT_TRUE(queue_.Claim("w", Now())->has_value());
  EXPECT_EQ(catalogue_.AddFile(id, {"a.jpg", NewId(), 1}, Now()).error().code, ErrorCode::kConflict);
  EXPECT_EQ(catalogue_.RemoveFile(id, "a.jpg").error().code, ErrorCode::kConflict);
  EXPECT_TRUE(catalogue_.AddFile(id, {"b.jpg", NewId(), 1}, Now()));
}

TEST_F(CatalogueTest, SaysWhatDoesNotExist) {
  EXPECT_EQ(catalogue_.GetFlight("x").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.ChangeFlight("x", {.name = "n"}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.DeleteFlight("x").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.ListFiles("x").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(catalogue_.AddFile("x", {"a", NewId(), 1}, Now()).error().code, ErrorCode::kNotFound);
  const std::string id = catalogue_.AddFlight("f", "{}", Now())->id;
  EXPECT_EQ(catalogue_.RemoveFile(id, "a.jpg").error().code, ErrorCode::kNotFound);
}

TEST_F(CatalogueTest, AReceiverWithManyMessagesHidesNoOthers) {
  constexpr int kFew = 2;
  Webhooks webhooks(*db_);
  const auto end_job = [&] {
    const std::string flight = test::ValueOf(catalogue_.AddFlight("field", "{}", now_)).id;
    ASSERT_TRUE(queue_.Cancel(test::ValueOf(queue_.Add(flight, "{}", now_)).id, now_));
  };
  ASSERT_TRUE(webhooks.Add("https://silent.example.org/", "secret", now_));
  for (int i = 0; i <= kFew; ++i) end_job();
  const std::string heard = test::ValueOf(webhooks.Add("https://receiver.example.org/", "secret", now_)).id;
  end_job();
  const std::vector<Delivery> due = test::ValueOf(webhooks.Due(db_->ages().Now(), kFew));
  ASSERT_EQ(due.size(), 3u);
  EXPECT_LT(due[0].event_seq, due[1].event_seq);
  EXPECT_EQ(due[2].webhook.id, heard);
}

}  // namespace
}  // namespace skyquilt::storage
