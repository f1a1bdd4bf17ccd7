#include "storage/jobs/map_exports.h"

#include <fstream>
#include <set>

#include "storage/blobs/folder_blobs.h"
#include "storage/catalogue/tokens.h"
#include "storage/catalogue/trash.h"
#include "storage/db/ids.h"
#include "storage/folder/sweep.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {
namespace {

class MapExportsTest : public CatalogueFixture {
 protected:
  std::string Flight() { return catalogue_.AddFlight("field", "{}", Now())->id; }
  static MapExport Wish(const std::string& flight, const std::string& request, int revision = 1) {
    MapExport wish;
    wish.flight_id = flight;
    wish.revision = revision;
    wish.request = request;
    wish.format = "kmz";
    wish.owner = "me";
    return wish;
  }
  MapExport Ask(const std::string& flight, const std::string& request = R"({"format":"kmz"})",
                int revision = 1) {
    return *exports_.Add(Wish(flight, request, revision), Now());
  }
  // By a link to the flight, which there is from then on.
  Result<MapExport> AskByLink(const std::string& flight, const std::string& link,
                              const std::string& request) {
    if (links_.insert(link).second) {
      Token token{link, link, std::string(32, 'h') + link, Scope::kRead, Now()};
      token.flight_id = flight;
      EXPECT_TRUE(tokens_.AddShare(token));
    }
    MapExport wish = Wish(flight, request);
    wish.owner = link;
    wish.is_of_link = true;
    return exports_.Add(wish, Now());
  }

  MapExports exports_{*db_};
  Tokens tokens_{*db_};
  std::set<std::string> links_;
};

TEST_F(MapExportsTest, AWishIsNewUntilAClaimHasLooked) {
  EXPECT_TRUE(exports_.HasNew());  // of before the start
  EXPECT_FALSE(*exports_.Claim(Now()));
  EXPECT_FALSE(exports_.HasNew());
  Ask(Flight());
  EXPECT_TRUE(exports_.HasNew());
  ASSERT_TRUE(db_->Lock()->Exec("ALTER TABLE map_export RENAME TO map_export_away"));
  EXPECT_FALSE(exports_.Claim(Now()).ok());
  EXPECT_TRUE(exports_.HasNew());
  ASSERT_TRUE(db_->Lock()->Exec("ALTER TABLE map_export_away RENAME TO map_export"));
  EXPECT_TRUE(*exports_.Claim(Now()));
  EXPECT_FALSE(exports_.HasNew());
}

TEST_F(MapExportsTest, GoesItsWayAndIsKeptForADay) {
  const std::string flight = Flight();
  const MapExport asked = Ask(flight);
  EXPECT_EQ(asked.state, ExportState::kAccepted);
  const auto claimed = test::ValueOf(*exports_.Claim(Now()));
  EXPECT_EQ(claimed.id, asked.id);
  EXPECT_EQ(claimed.request, asked.request);
  EXPECT_FALSE(*exports_.Claim(Now()));  // it is being made
  EXPECT_TRUE(*exports_.Heartbeat(claimed, 0.5, Now()));
  EXPECT_EQ(exports_.Get(flight, asked.id)->progress, 0.5);
  EXPECT_TRUE(*exports_.Succeed(claimed, 77, Now()));
  const auto made = test::ValueOf(exports_.Get(flight, asked.id));
  EXPECT_EQ(made.state, ExportState::kSuccessful);
  EXPECT_EQ(made.bytes, 77);
  ASSERT_TRUE(made.expires);
  EXPECT_NEAR(static_cast<double>(ToUs(*made.expires) - ToUs(db_->ages().Now())), 24 * 3600e6, 60e6);
  EXPECT_TRUE(exports_.Expired()->empty());
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE map_export SET expires_us=1"));
  ASSERT_EQ(exports_.Expired()->size(), 1u);
  EXPECT_EQ(ExportKey(exports_.Expired()->front()), "flights/" + flight + "/exports/" + asked.id + ".kmz");
}

TEST_F(MapExportsTest, TheSameWishIsTheSameExport) {
  const std::string flight = Flight();
  const MapExport first = Ask(flight);
  EXPECT_EQ(Ask(flight).id, first.id);
  EXPECT_NE(Ask(flight, "{}").id, first.id);
  EXPECT_NE(Ask(flight, R"({"format":"kmz"})", 2).id, first.id);
  // One that failed is made again.
  EXPECT_TRUE(*exports_.Fail(**exports_.Claim(Now()), {ErrorCode::kOutOfSpace, "no room", ""}, Now()));
  EXPECT_EQ(exports_.Get(flight, first.id)->error_message, "no room");
  EXPECT_NE(Ask(flight).id, first.id);
}

TEST_F(MapExportsTest, AFlightHasSoManyAndNoMore) {
  const std::string flight = Flight();
  for (int i = 0; i < MapExports::kMaxOfFlight; ++i) Ask(flight, std::to_string(i));
  const MapExport wish = Wish(flight, "");
  EXPECT_EQ(test::ErrorOf(exports_.Add(wish, Now())).code, ErrorCode::kConflict);
  ASSERT_TRUE(exports_.Remove(exports_.List(flight)->front().id));
  EXPECT_TRUE(exports_.Add(wish, Now()));
  EXPECT_EQ(exports_.List(flight)->size(), static_cast<std::size_t>(MapExports::kMaxOfFlight));
}

TEST_F(MapExportsTest, ALinkHasOneThatTakesNoPlaceAndComesLast) {
  const std::string flight = Flight();
  const auto first = test::ValueOf(AskByLink(flight, "one", "a"));
  EXPECT_EQ(test::ErrorOf(AskByLink(flight, "one", "b")).code, ErrorCode::kConflict);
  EXPECT_EQ(AskByLink(flight, "one", "a")->id, first.id);
  ASSERT_TRUE(AskByLink(flight, "two", "c"));
  for (int i = 0; i < MapExports::kMaxOfFlight; ++i) {
    Ask(flight, std::to_string(i));
    EXPECT_FALSE((*exports_.Claim(Now()))->is_of_link);  // though those of links were first
  }
  // Once made, it gives its place to the next.
  const auto claimed = test::ValueOf(*exports_.Claim(Now()));
  EXPECT_EQ(claimed.id, first.id);
  EXPECT_TRUE(claimed.is_of_link);
  ASSERT_TRUE(*exports_.Succeed(claimed, 7, Now()));
  ASSERT_TRUE(exports_.Get(flight, first.id));
  ASSERT_TRUE(AskByLink(flight, "one", "b"));
  EXPECT_FALSE(exports_.Get(flight, first.id));
  ASSERT_EQ(exports_.Expired()->size(), 1u);
  EXPECT_EQ(exports_.Expired()->front().id, first.id);
  // Whoever has more rights and wants the same has it as their own.
  const MapExport taken = Ask(flight, "c");
  EXPECT_TRUE(tokens_.Revoke("two"));
  EXPECT_EQ(exports_.Get(flight, taken.id)->owner, "me");
}

TEST_F(MapExportsTest, ThoseOfALinkGoWithIt) {
  const std::string flight = Flight();
  const MapExport of_owner = Ask(flight, "mine");
  ASSERT_TRUE(*exports_.Claim(Now()));
  const MapExport made = *AskByLink(flight, "one", "a");
  ASSERT_TRUE(*exports_.Succeed(**exports_.Claim(Now()), 7, Now()));
  const MapExport under_way = *AskByLink(flight, "two", "b");
  const auto claimed = *exports_.Claim(Now());
  const MapExport by_its_day = *AskByLink(flight, "three", "c");
  ASSERT_TRUE(tokens_.RevokeShare(flight, "one"));
  ASSERT_TRUE(tokens_.Revoke("two"));
  EXPECT_FALSE(*exports_.Heartbeat(*claimed, 0.5, Now()));
  EXPECT_FALSE(*exports_.Succeed(*claimed, 7, Now()));
  ASSERT_TRUE(exports_.EndThoseOfEndedLinks(Now()));
  EXPECT_TRUE(exports_.Get(flight, by_its_day.id));
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE token SET expires_us=1 WHERE id='three'"));
  ASSERT_TRUE(exports_.EndThoseOfEndedLinks(Now()));
  for (const MapExport& gone : {made, under_way, by_its_day}) EXPECT_FALSE(exports_.Get(flight, gone.id));
  ASSERT_EQ(exports_.Expired()->size(), 1u);  // whose file is to be removed
  EXPECT_EQ(exports_.Expired()->front().id, made.id);
  EXPECT_TRUE(exports_.Get(flight, of_owner.id));
  // A request that was on its way when its link ended leaves nothing.
  EXPECT_EQ(AskByLink(flight, "two", "b").error().code, ErrorCode::kForbidden);
}

TEST_F(MapExportsTest, WhoeverMakesWhatWasRemovedHearsOfIt) {
  const std::string flight = Flight();
  const MapExport asked = Ask(flight);
  const auto claimed = *exports_.Claim(Now());
  ASSERT_TRUE(exports_.Remove(asked.id));
  EXPECT_FALSE(*exports_.Heartbeat(*claimed, 0.1, Now()));
  EXPECT_FALSE(*exports_.Succeed(*claimed, 1, Now()));
  EXPECT_FALSE(exports_.Get(flight, asked.id));
}

TEST_F(MapExportsTest, ADeadServersExportIsTakenUpTwiceAndThenFails) {
  const std::string flight = Flight();
  const MapExport asked = Ask(flight);
  Time now = Now();
  const auto first = *exports_.Claim(now);
  now += MapExports::kLease + std::chrono::seconds(2);
  const auto second = test::ValueOf(*exports_.Claim(now));
  EXPECT_FALSE(*exports_.Heartbeat(*first, 0.5, now));  // the dead one, come alive
  EXPECT_TRUE(*exports_.GiveBack(second));              // a stop is no attempt
  ASSERT_TRUE(*exports_.Claim(now));
  ASSERT_TRUE(exports_.TakeUpAfterRestart());
  EXPECT_FALSE(*exports_.Claim(now));
  EXPECT_EQ(exports_.Get(flight, asked.id)->state, ExportState::kFailed);
}

TEST_F(MapExportsTest, ThoseOfFlightsInTheTrashTakeNoPlaceOfOthers) {
  std::vector<std::string> flights;
  for (int i = 0; i < MapExports::kMaxOpen; ++i) {
    if (i % MapExports::kMaxOfFlight == 0) flights.push_back(Flight());
    Ask(flights.back(), std::to_string(i));
  }
  const MapExport wish = Wish(Flight(), "{}");
  EXPECT_EQ(exports_.Add(wish, Now()).error().code, ErrorCode::kRateLimited);
  ASSERT_TRUE(Trash(*db_).Put(flights.front(), Now()));
  EXPECT_TRUE(exports_.Add(wish, Now()));
}

TEST_F(MapExportsTest, GoesWithItsFlight) {
  const std::string flight = Flight();
  const MapExport asked = Ask(flight);
  ASSERT_TRUE(catalogue_.DeleteFlight(flight));
  EXPECT_FALSE(exports_.Get(flight, asked.id));
  EXPECT_FALSE(*exports_.Claim(Now()));
}

TEST_F(MapExportsTest, BlobsOfExportsThatNobodyKnowsAreTakenAndNoOthers) {
  const std::string flight = Flight();
  FolderBlobs blobs(dir_.path() / "store");
  const auto put = [&](const std::string& key) {
    std::ofstream(dir_.path() / "file") << "x";
    ASSERT_TRUE(blobs.Put(key, dir_.path() / "file"));
  };
  const std::string below = "flights/" + flight + "/exports/";
  const std::string known = ExportKey(Ask(flight)), stray = below + NewId() + ".tif";
  const std::string of_user = below + "mine.tif";
  for (const std::string& key : {known, stray, of_user}) put(key);
  EXPECT_EQ(*SweepExportBlobs(blobs, catalogue_, exports_, std::chrono::hours(1)), 0);  // too young
  EXPECT_EQ(*SweepExportBlobs(blobs, catalogue_, exports_, std::chrono::seconds(0)), 1);
  EXPECT_TRUE(blobs.Find(known).ok());
  EXPECT_FALSE(blobs.Find(stray).ok());
  EXPECT_TRUE(blobs.Find(of_user).ok());
}

}  // namespace
}  // namespace skyquilt::storage
