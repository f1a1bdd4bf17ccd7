#include "server/watch/sent_ledger.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/support/temporary_folder.h"

namespace skyquilt::server {
namespace {

Digest Numbered(int number) { return Hasher().Add(number).Finish(); }

class SentLedgerTest : public ::testing::Test {
 protected:
  SentLedger Open() const {
    Result<SentLedger> ledger = SentLedger::Open(path_);
    EXPECT_TRUE(ledger) << ledger.error().message;
    return *std::move(ledger);
  }
  std::string Text() const {
    std::ostringstream text;
    text << std::ifstream(path_).rdbuf();
    return text.str();
  }
  test::TemporaryFolder scratch_;
  const std::filesystem::path path_ = scratch_.path() / "deep" / "sent.jsonl";
};

TEST_F(SentLedgerTest, RemembersThroughAnEndOfTheProcess) {
  {
    SentLedger ledger = Open();
    EXPECT_EQ(ledger.Find({Numbered(1)}), nullptr);
    ASSERT_TRUE(ledger.Begin("k1", "Field \"7\""));
    ASSERT_TRUE(ledger.WillSend("k1", {{Numbered(1), "a.jpg"}, {Numbered(2), "b/a.jpg"}}));
    ASSERT_TRUE(ledger.Made("k1", "f123"));
    ASSERT_TRUE(ledger.Sent("k1", {Numbered(1)}));
  }
  SentLedger ledger = Open();
  EXPECT_TRUE(ledger.IsSent(Numbered(1)));
  EXPECT_FALSE(ledger.IsSent(Numbered(2)));
  const SentFlight* flight = ledger.Find({Numbered(9), Numbered(2)});
  ASSERT_NE(flight, nullptr);
  EXPECT_EQ(flight->id, "f123");
  EXPECT_EQ(flight->name, "Field \"7\"");
  EXPECT_EQ(flight->files.at(Numbered(2)), "b/a.jpg");
}

TEST_F(SentLedgerTest, AFlightThatIsGoneIsNotContinuedButItsFilesWereSent) {
  SentLedger ledger = Open();
  ASSERT_TRUE(ledger.Begin("k1", "one"));
  ASSERT_TRUE(ledger.WillSend("k1", {{Numbered(1), "a.jpg"}}));
  ASSERT_TRUE(ledger.Sent("k1", {Numbered(1)}));
  ASSERT_TRUE(ledger.Gone("k1"));
  EXPECT_EQ(ledger.Find({Numbered(1)}), nullptr);
  EXPECT_TRUE(ledger.IsSent(Numbered(1)));
}

TEST_F(SentLedgerTest, TwoProcessesReadWhatTheOtherWrote) {
  SentLedger one = Open(), other = Open();
  ASSERT_TRUE(one.Begin("k1", "one"));
  ASSERT_TRUE(one.WillSend("k1", {{Numbered(1), "a.jpg"}}));
  ASSERT_TRUE(other.Begin("k2", "other"));
  ASSERT_TRUE(other.Refresh());
  ASSERT_NE(other.Find({Numbered(1)}), nullptr);
  EXPECT_EQ(other.Find({Numbered(1)})->key, "k1");
}

TEST_F(SentLedgerTest, WhatAKillToreOrAHandChangedDoesNoHarm) {
  {
    SentLedger ledger = Open();
    ASSERT_TRUE(ledger.Begin("k1", "one"));
    ASSERT_TRUE(ledger.WillSend("k1", {{Numbered(1), "a.jpg"}}));
  }
  std::ofstream(path_, std::ios::app)
      << "nonsense\n[]\n{\"flight\":7}\n{\"flight\":\"k1\",\"files\":{\"zz\":\"x\",\"00\":3}}\n"
         "{\"flight\":\"k1\",\"sent\":[1,\"q\",null]}\n{\"flight\":\"k1\",\"se";
  {
    SentLedger ledger = Open();
    EXPECT_FALSE(ledger.IsSent(Numbered(1)));
    EXPECT_EQ(ledger.At("k1").files.size(), 1u);
    ASSERT_TRUE(ledger.Sent("k1", {Numbered(1)}));
  }
  EXPECT_TRUE(Open().IsSent(Numbered(1))) << Text();
}

TEST_F(SentLedgerTest, AnotherFileIsRefusedAndKept) {
  std::filesystem::create_directories(path_.parent_path());
  std::ofstream(path_) << "somebody's diary of several years, longer than our first line";
  const std::string before = Text();
  const Result<SentLedger> refused = SentLedger::Open(path_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("--state"), std::string::npos);
  EXPECT_EQ(Text(), before);
}

}  // namespace
}  // namespace skyquilt::server
