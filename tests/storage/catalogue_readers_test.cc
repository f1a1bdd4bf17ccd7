// Reading the catalogue while somebody writes it.
#include <atomic>
#include <thread>
#include <vector>

#include "storage/catalogue/event_log.h"
#include "storage/catalogue/tokens.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {
namespace {

class CatalogueReadersTest : public CatalogueFixture {
 protected:
  CatalogueReadersTest() : CatalogueFixture(/*readers=*/3) {}
};

TEST_F(CatalogueReadersTest, WaitForNoWriterOfAnotherProcess) {
  const std::string flight = catalogue_.AddFlight("field", "{}", Now())->id;
  const auto others = *OpenTestCatalogue(dir_.path() / "catalogue.db");
  const auto other = others->Lock();
  ASSERT_TRUE(other->Exec(std::string(TestsPostgres() ? "BEGIN" : "BEGIN IMMEDIATE") +
                          "; UPDATE flight SET name='unsaid'"));
  EXPECT_EQ(catalogue_.GetFlight(flight)->name, "field");
  EXPECT_TRUE(queue_.Count());
  EXPECT_TRUE(Tokens(*db_).Known());
  EXPECT_EQ(*EventLog(*db_).Latest(), 0);
  ASSERT_TRUE(other->Exec("COMMIT"));
  EXPECT_EQ(catalogue_.GetFlight(flight)->name, "unsaid");
}

TEST_F(CatalogueReadersTest, WaitForNoWriterOfThisProcess) {
  const std::string flight = catalogue_.AddFlight("field", "{}", Now())->id;
  const auto writing = db_->Lock();  // a thread that waits for another's write lock holds this
  EXPECT_EQ(catalogue_.GetFlight(flight)->name, "field");
  EXPECT_TRUE(Tokens(*db_).Read());
}

TEST_F(CatalogueReadersTest, SeeWhatWasJustWritten) {
  for (int i = 0; i < 50; ++i) {
    const std::string flight = catalogue_.AddFlight("field", "{}", Now())->id;
    EXPECT_TRUE(catalogue_.GetFlight(flight));
  }
}

TEST_F(CatalogueReadersTest, HearWhetherAnythingWasWritten) {
  EXPECT_TRUE(db_->WasWritten()) << "what was written before";
  EXPECT_EQ(db_->WasWritten(), TestsPostgres()) << "there it is not known";
  const auto others = *OpenTestCatalogue(dir_.path() / "catalogue.db");
  (void)db_->WasWritten();
  {
    const auto other = others->Lock();
    ASSERT_TRUE(
        other->Exec(std::string(TestsPostgres() ? "BEGIN" : "BEGIN IMMEDIATE") + "; DELETE FROM flight"));
    EXPECT_EQ(db_->WasWritten(), TestsPostgres()) << "it may come to nothing";
    ASSERT_TRUE(other->Exec("INSERT INTO flight(id,name,created_us) VALUES('a','field',1); COMMIT"));
  }
  EXPECT_TRUE(db_->WasWritten());
  ASSERT_TRUE(catalogue_.AddFlight("by this process", "{}", Now()));
  EXPECT_TRUE(db_->WasWritten());
  (void)catalogue_.GetFlight("a");
  EXPECT_EQ(db_->WasWritten(), TestsPostgres());
}

TEST_F(CatalogueReadersTest, AreWokenByWhatIsWritten) {
  if (TestsPostgres()) GTEST_SKIP() << "there who waits looks again and again";
  EXPECT_TRUE(db_->WaitForWrites()) << "what was written before";
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const auto others = *OpenTestCatalogue(dir_.path() / "catalogue.db");
    EXPECT_TRUE(Catalogue(*others).AddFlight("field", "{}", Now()));
  });
  // The folder stirs while the file is opened, the change may show a moment later.
  bool is_heard = false;
  for (int tries = 0; tries < 25 && !is_heard; ++tries) is_heard = db_->WaitForWrites();
  writer.join();
  EXPECT_TRUE(is_heard);
}

TEST_F(CatalogueReadersTest, CannotWrite) {
  const auto db = db_->Read();
  EXPECT_FALSE(db->Exec("DELETE FROM flight"));
}

TEST_F(CatalogueReadersTest, TakeTurnsWhereTheyAreMoreThanConnections) {
  const std::string flight = catalogue_.AddFlight("field", "{}", Now())->id;
  std::vector<std::thread> readers;
  std::atomic<int> found = 0;
  for (int i = 0; i < 8; ++i) {
    readers.emplace_back([&] {
      for (int j = 0; j < 100; ++j) found += catalogue_.GetFlight(flight).ok() ? 1 : 0;
    });
  }
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(catalogue_.ChangeFlight(flight, {.name = std::to_string(i)}));
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(found, 800);
}

}  // namespace
}  // namespace skyquilt::storage
