#include "storage/catalogue/flight_record.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "storage/catalogue/catalogue.h"
#include "storage/db/ids.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

FlightRecord Sample() {
  FlightRecord record;
  record.name = "Field \"north\"\n";
  record.options = R"({"gsd_m":0.05})";
  record.owner = "token";
  record.created = FromUs(1'700'000'000'000'000);
  return record;
}

TEST(FlightRecord, TellsAgainWhatWasWritten) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path());
  const FlightRecords records(dir);
  const std::string id = NewId(), first = NewId(), second = NewId();
  ASSERT_TRUE(records.Begin(id, Sample()));
  ASSERT_TRUE(records.AddFile(id, first, {"høyde.jpg", 7, FromUs(5), false}));
  ASSERT_TRUE(records.AddFile(id, second, {"b.jpg", 8, FromUs(6), false}));
  ASSERT_TRUE(records.RemoveFile(id, second));
  FlightRecord change;
  change.name = "South";
  ASSERT_TRUE(records.Change(id, change));
  const auto read = *ReadFlightRecord(dir.Flight(id));
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->is_whole);
  EXPECT_EQ(read->name, "South");
  EXPECT_EQ(read->options, Sample().options);
  EXPECT_EQ(read->created, Sample().created);
  EXPECT_EQ(read->files.at(first).name, "høyde.jpg");
  EXPECT_EQ(read->files.at(first).bytes, 7);
  EXPECT_FALSE(read->files.at(first).is_removed);
  EXPECT_TRUE(read->files.at(second).is_removed);
  EXPECT_FALSE(read->is_deleted);
  FlightRecord marks;
  marks.tags = {"maize", "é"};
  marks.is_kept = true;
  ASSERT_TRUE(records.Change(id, marks));
  EXPECT_EQ((*ReadFlightRecord(dir.Flight(id)))->tags, marks.tags);
  EXPECT_EQ((*ReadFlightRecord(dir.Flight(id)))->is_kept, true);
  EXPECT_EQ((*ReadFlightRecord(dir.Flight(id)))->name, "South");
  ASSERT_TRUE(records.Deleting(id, Now()));
  EXPECT_TRUE((*ReadFlightRecord(dir.Flight(id)))->is_deleting);
  ASSERT_TRUE(records.Change(id, {}));  // the deletion came to nothing
  EXPECT_FALSE((*ReadFlightRecord(dir.Flight(id)))->is_deleting);
  ASSERT_TRUE(records.Deleted(id, Now()));
  EXPECT_TRUE((*ReadFlightRecord(dir.Flight(id)))->is_deleted);
}

TEST(FlightRecord, ALineTornByAPowerCutCostsOnlyItself) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path());
  const FlightRecords records(dir);
  const std::string id = NewId(), first = NewId(), second = NewId();
  ASSERT_TRUE(records.Begin(id, Sample()));
  ASSERT_TRUE(records.AddFile(id, first, {"a.jpg", 7, FromUs(5), false}));
  const auto path = dir.Flight(id) / kFlightRecordName;
  std::ofstream(path, std::ios::app) << R"({"file":{"stored":")";
  EXPECT_TRUE((*ReadFlightRecord(dir.Flight(id)))->is_whole);
  ASSERT_TRUE(records.AddFile(id, second, {"b.jpg", 8, FromUs(6), false}));
  const auto read = *ReadFlightRecord(dir.Flight(id));
  EXPECT_EQ(read->files.size(), 2u);
  EXPECT_EQ(read->files.at(second).name, "b.jpg");
}

// Several recorded files that a catalogue lacks are what shows an older one, which no server starts with.
TEST(FlightRecord, NamesNoFileWhoseCommitFailed) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path());
  const auto db = *CatalogueDb::Open(dir.Catalogue());
  Catalogue catalogue(*db, FlightRecords(dir));
  const std::string flight = catalogue.AddFlight("f", "{}", Now())->id;
  const std::string kept = NewId(), instead = NewId(), other = NewId();
  ASSERT_TRUE(catalogue.AddFile(flight, {"a.jpg", kept, 1}, Now()));
  // A commit finds a row without what it belongs to.
  ASSERT_TRUE(db->Lock()->Exec(
      "CREATE TABLE stray(id TEXT REFERENCES flight(id) DEFERRABLE INITIALLY DEFERRED);"
      "CREATE TRIGGER spoil AFTER INSERT ON file BEGIN INSERT INTO stray VALUES('none'); END"));
  EXPECT_FALSE(catalogue.AddFile(flight, {"a.jpg", instead, 2}, Now()));
  EXPECT_FALSE(catalogue.AddFileUnderFreeName(flight, {"b.jpg", other, 3}, Now()));
  const auto record = *ReadFlightRecord(dir.Flight(flight));
  ASSERT_TRUE(record);
  EXPECT_TRUE(record->is_whole);
  EXPECT_TRUE(record->files.at(instead).is_removed);
  EXPECT_TRUE(record->files.at(other).is_removed);
  EXPECT_FALSE(record->files.at(kept).is_removed);
  EXPECT_EQ(record->files.at(kept).replaced_by, "");
  EXPECT_EQ(catalogue.FindFile(flight, "a.jpg")->value().stored_name, kept);
}

// Where photos lie elsewhere a few of such keep each start from its catalogue; here removing is to make room.
TEST(FlightRecord, IsNoLongerTrueOfWhatWasRemovedOnlyWhereThatIsSeen) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path());
  const auto db = *CatalogueDb::Open(dir.Catalogue());
  Catalogue catalogue(*db, FlightRecords(dir));
  const std::string flight = catalogue.AddFlight("f", "{}", Now())->id;
  ASSERT_TRUE(catalogue.AddFile(flight, {"a.jpg", NewId(), 1}, Now()));
  const auto record = dir.Flight(flight) / kFlightRecordName;
  std::filesystem::remove(record);
  std::filesystem::create_directory(record);  // takes nothing, as on a full disk
  std::ofstream(dir.BlobsMarker()) << R"({"blobs":"s3://far/"})";
  EXPECT_FALSE(catalogue.RemoveFile(flight, "a.jpg"));
  EXPECT_EQ(catalogue.ListFiles(flight)->size(), 1u);
  std::filesystem::remove(dir.BlobsMarker());
  EXPECT_TRUE(catalogue.RemoveFile(flight, "a.jpg"));
}

TEST(FlightRecord, TakesAnyBytes) {
  for (const char* bad : {"", "\n\n", "null\n[]\n{}\n", "{\"flight\":{\"name\":7,\"created_us\":\"x\"}}\n",
                          "{\"file\":{\"stored\":\"a\",\"name\":\"b\",\"bytes\":1,\"created_us\":2}}\n"})
    EXPECT_FALSE(ParseFlightRecord(bad).is_whole) << bad;
  EXPECT_FALSE(ParseFlightRecord(std::string(100'000, '[')).is_whole);
  const std::string good = "{\"flight\":{\"name\":\"f\"}}\n{\"removed\":\"x\"}\n{\"deleting\":1}\n";
  ASSERT_TRUE(ParseFlightRecord(good).is_whole);
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string broken = good;
    broken[random() % broken.size()] = static_cast<char>(random());
    (void)ParseFlightRecord(broken).is_whole;
  }
}

TEST(FlightRecord, NeverMakesADataFolderAnew) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path() / "data");
  const FlightRecords records(dir);
  std::filesystem::remove_all(dir.root());
  EXPECT_EQ(records.Begin(NewId(), Sample()).error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(records.Deleting(NewId(), Now()).error().code, ErrorCode::kUnavailable);
  EXPECT_FALSE(std::filesystem::exists(dir.root()));
}

}  // namespace
}  // namespace skyquilt::storage
