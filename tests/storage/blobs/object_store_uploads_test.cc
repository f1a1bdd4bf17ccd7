// Resumable uploads whose bytes lie elsewhere: two servers on one catalogue and one store.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>

#include "storage/db/ids.h"
#include "storage/folder/object_store/sweep_blobs.h"
#include "storage/uploads/upload_chunks.h"
#include "storage/uploads/upload_spool.h"
#include "tests/storage/blobs/far_folder.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

constexpr std::size_t kMib = std::size_t{1} << 20;

std::string Pattern(std::size_t count) {
  std::string bytes(count, '\0');
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<char>(i * 31 + i / 4096);
  return bytes;
}

std::span<const std::uint8_t> BytesOf(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

class UploadsOfTwoServers : public testing::Test {
 protected:
  struct Node {
    Node(const UploadsOfTwoServers& test, const char* name)
        : store(*DataDir::Open(test.folder_ / name, NewId()), test.blobs_),
          spool(*test.db_, const_cast<Catalogue&>(test.catalogue_), store) {}
    PhotoStore store;
    UploadSpool spool;
  };

  SpooledUpload Begin(std::int64_t length) { return *a_.spool.Create(Wish("a.jpg", length), now_); }
  SpooledUpload Wish(const char* name, std::optional<std::int64_t> length, const char* concat = "") const {
    SpooledUpload wish;
    wish.flight_id = flight_;
    wish.name = name;
    wish.length = length;
    wish.concat = concat;
    return wish;
  }
  Result<SpooledUpload> Send(Node& node, const std::string& id, std::int64_t offset, std::string_view bytes) {
    auto append = node.spool.Begin(id, offset, false, now_);
    if (!append) return append.error();
    for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), kMib))) {
      const Result<void> written = (*append)->Write(BytesOf(bytes.substr(0, kMib)));
      if (!written) return written.error();
    }
    return (*append)->Commit(now_);
  }
  std::string Stored() {
    const auto files = *catalogue_.ListFiles(flight_);
    return files.empty() ? ""
                         : *blobs_->ReadRange(FilesPrefix(flight_) + files[0].stored_name, 0, 100 * kMib);
  }
  std::size_t Chunks() { return blobs_->List("uploads/")->size(); }

  test::TemporaryFolder folder_;
  std::shared_ptr<test::FarFolder> blobs_ = std::make_shared<test::FarFolder>(folder_ / "far");
  std::unique_ptr<CatalogueDb> db_ = *CatalogueDb::Open(folder_ / "catalogue.db");
  Catalogue catalogue_{*db_};
  const std::string flight_ = catalogue_.AddFlight("a", "{}", Now())->id;
  const Time now_ = db_->ages().Now();
  Node a_{*this, "a"}, b_{*this, "b"};
};

TEST_F(UploadsOfTwoServers, KeepAFileThatTheCatalogueMayHaveTaken) {
  const SpooledUpload upload = Begin(8);
  EXPECT_EQ(Send(a_, upload.id, 0, "half")->offset, 4);
  const DataDir dir = *DataDir::Open(folder_ / "gone", NewId());
  Catalogue away(*db_, FlightRecords(dir));
  UploadSpool spool(*db_, away, a_.store);
  std::filesystem::remove(dir.Flights());  // as a database whose connection is lost at the commit
  {
    const auto append = test::ValueOf(spool.Begin(upload.id, 4, false, now_));
    ASSERT_TRUE(append->Write(BytesOf("full")));
    EXPECT_EQ(test::ErrorOf(append->Commit(now_)).code, ErrorCode::kUnavailable);
  }
  EXPECT_EQ(blobs_->List(FilesPrefix(flight_))->size(), 1U);
  EXPECT_TRUE(b_.spool.Find(upload.id, now_)->is_done);
  EXPECT_EQ(Stored(), "halffull");
}

TEST_F(UploadsOfTwoServers, GoOnAtTheOther) {
  const std::string bytes = Pattern(40 * kMib + 123);
  const SpooledUpload upload = Begin(static_cast<std::int64_t>(bytes.size()));
  EXPECT_EQ(Send(a_, upload.id, 0, std::string_view(bytes).substr(0, 20 * kMib))->offset, 20 * kMib);
  EXPECT_EQ(b_.spool.Find(upload.id, now_)->offset, static_cast<std::int64_t>(20 * kMib));
  EXPECT_EQ(Send(b_, upload.id, 20 * kMib, std::string_view(bytes).substr(20 * kMib, 7))->offset,
            20 * kMib + 7);
  EXPECT_GT(Chunks(), 2U);
  const auto done =
      test::ValueOf(Send(a_, upload.id, 20 * kMib + 7, std::string_view(bytes).substr(20 * kMib + 7)));
  EXPECT_TRUE(done.is_done);
  EXPECT_TRUE(Stored() == bytes);
  EXPECT_EQ(Chunks(), 0U);
  for (const Node* node : {&a_, &b_}) {
    EXPECT_TRUE(std::filesystem::is_empty(node->store.dir().Incoming()));
    EXPECT_TRUE(std::filesystem::is_empty(node->store.dir().Uploads()));
  }
}

TEST_F(UploadsOfTwoServers, ArePutOnceWhereTheyComeAtOnce) {
  const std::string bytes = Pattern(3 * kMib);
  const SpooledUpload upload = Begin(static_cast<std::int64_t>(bytes.size()));
  const int before = blobs_->puts_left;
  ASSERT_TRUE(Send(a_, upload.id, 0, bytes)->is_done);
  EXPECT_EQ(before - blobs_->puts_left, 1);
  EXPECT_TRUE(Stored() == bytes);
}

TEST_F(UploadsOfTwoServers, AreNotFilledUpWithZerosWhereAFolderLostBytes) {
  const PhotoStore folder(*DataDir::Open(folder_ / "before", NewId()));
  UploadSpool spool(*db_, catalogue_, folder);
  const SpooledUpload upload = *spool.Create(Wish("a.jpg", static_cast<std::int64_t>(2 * kMib)), now_);
  {
    const auto append = spool.Begin(upload.id, 0, false, now_);
    ASSERT_TRUE((*append)->Write(BytesOf(Pattern(kMib))));
    ASSERT_TRUE((*append)->Commit(now_));
  }
  std::filesystem::resize_file(folder.dir().Uploads() / upload.id, kMib - 1);
  const auto again = spool.Begin(upload.id, static_cast<std::int64_t>(kMib), false, now_);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kCorrupt);
}

TEST_F(UploadsOfTwoServers, RefuseOneWhoseFirstBytesLieInAFolder) {
  const std::string bytes = Pattern(2 * kMib);
  const PhotoStore folder(*DataDir::Open(folder_ / "before", NewId()));
  UploadSpool before(*db_, catalogue_, folder);
  const SpooledUpload upload = *before.Create(Wish("a.jpg", static_cast<std::int64_t>(bytes.size())), now_);
  {
    const auto append = before.Begin(upload.id, 0, false, now_);
    ASSERT_TRUE((*append)->Write(BytesOf(std::string_view(bytes).substr(0, kMib))));
    ASSERT_EQ((*append)->Commit(now_)->offset, static_cast<std::int64_t>(kMib));
  }
  EXPECT_EQ(test::ErrorOf(Send(a_, upload.id, kMib, std::string_view(bytes).substr(kMib))).code,
            ErrorCode::kCorrupt);
  EXPECT_EQ(Stored(), "");
}

// A client that gave one connection up goes on at the other server; what the first still holds is nobody's.
TEST_F(UploadsOfTwoServers, TakeTheBytesOfOneOnly) {
  const std::string bytes = Pattern(2 * kMib);
  const SpooledUpload upload = Begin(static_cast<std::int64_t>(bytes.size()));
  auto late = *a_.spool.Begin(upload.id, 0, false, now_);
  ASSERT_TRUE(late->Write(BytesOf(Pattern(kMib / 2))));
  ASSERT_TRUE(Send(b_, upload.id, 0, std::string_view(bytes).substr(0, kMib)));
  EXPECT_EQ(test::ErrorOf(late->Commit(now_)).code, ErrorCode::kConflict);
  late.reset();
  EXPECT_EQ(Chunks(), 1U);
  ASSERT_TRUE(Send(b_, upload.id, kMib, std::string_view(bytes).substr(kMib))->is_done);
  EXPECT_TRUE(Stored() == bytes);
}

TEST_F(UploadsOfTwoServers, PromiseNothingThatTheStoreDidNotTake) {
  const std::string bytes = Pattern(2 * kMib);
  const SpooledUpload upload = Begin(static_cast<std::int64_t>(bytes.size()));
  blobs_->puts_left = 0;
  EXPECT_EQ(Send(a_, upload.id, 0, std::string_view(bytes).substr(0, kMib)).error().code,
            ErrorCode::kUnavailable);
  EXPECT_EQ(b_.spool.Find(upload.id, now_)->offset, 0);
  blobs_->puts_left = 1'000;
  EXPECT_TRUE(Send(b_, upload.id, 0, bytes)->is_done);
  EXPECT_TRUE(Stored() == bytes);
}

TEST_F(UploadsOfTwoServers, JoinPartsThatCameToEither) {
  const std::string bytes = Pattern(3 * kMib);
  SpooledUpload part;
  part.concat = kPartOfUpload;
  part.length = static_cast<std::int64_t>(kMib);
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < 3; ++i) {
    Node& node = i == 1 ? b_ : a_;
    ids.push_back(node.spool.Create(part, now_)->id);
    ASSERT_TRUE(Send(node, ids.back(), 0, std::string_view(bytes).substr(i * kMib, kMib)));
  }
  const SpooledUpload wish = Wish("joined.jpg", {}, "final;");
  ASSERT_TRUE(b_.spool.Join(wish, ids, false, now_)->is_done);
  EXPECT_TRUE(Stored() == bytes);
  EXPECT_EQ(Chunks(), 0U);
}

// Of a file that this process may write no further, as of a full disk.
TEST_F(UploadsOfTwoServers, SayAtOnceThatADiskHasNoRoomForThem) {
  SpooledUpload part;
  part.concat = kPartOfUpload;
  std::vector<std::string> ids;
  for (const std::size_t count : {5 * kMib, 5 * kMib, kMib}) {
    part.length = static_cast<std::int64_t>(count);
    ids.push_back(a_.spool.Create(part, now_)->id);
    ASSERT_TRUE(Send(a_, ids.back(), 0, Pattern(count)));
  }
  // What comes behind is not asked for any more: nobody finds that it is gone.
  const std::vector<BlobInfo> last = *blobs_->List("uploads/" + ids.back() + "/");
  ASSERT_EQ(last.size(), 1U);
  ASSERT_TRUE(blobs_->Remove(last[0].key));
  const SpooledUpload wish = Wish("joined.jpg", {}, "final;");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit limited{rlim_t{8} << 20, before.rlim_max};
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limited), 0);
  const Result<SpooledUpload> joined = a_.spool.Join(wish, ids, false, now_);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  signal(SIGXFSZ, handler);
  ASSERT_FALSE(joined);
  EXPECT_EQ(joined.error().code, ErrorCode::kOutOfSpace) << joined.error().message;
}

TEST_F(UploadsOfTwoServers, AreSweptWhenNobodyListsThem) {
  const SpooledUpload upload = Begin(static_cast<std::int64_t>(2 * kMib));
  ASSERT_TRUE(Send(a_, upload.id, 0, Pattern(kMib)));
  ASSERT_TRUE(blobs_->PutIfAbsent(NewChunkKey(upload.id, 0), "a chunk whose server died"));
  EXPECT_EQ(*SweepChunks(*db_, *blobs_, kOrphanAge), 0);
  EXPECT_EQ(*SweepChunks(*db_, *blobs_, std::chrono::seconds(0)), 1);
  EXPECT_EQ(Chunks(), 1U);
  EXPECT_EQ(*a_.spool.RemoveExpired(now_ + kUploadLifetime + std::chrono::hours(1)), 1);
  EXPECT_EQ(Chunks(), 0U);
  EXPECT_EQ(b_.spool.Find(upload.id, now_).error().code, ErrorCode::kNotFound);
}

TEST_F(UploadsOfTwoServers, GoWithTheirChunksWhenTheyAreRemoved) {
  const SpooledUpload upload = Begin(static_cast<std::int64_t>(2 * kMib));
  ASSERT_TRUE(Send(a_, upload.id, 0, Pattern(kMib)));
  ASSERT_TRUE(b_.spool.Remove(upload.id, now_));
  EXPECT_EQ(Chunks(), 0U);
}

TEST(ParseChunks, ReadsWhatItWroteAndRefusesAnythingElse) {
  const std::vector<UploadChunk> chunks = {{NewChunkKey(NewId(), 0), 5}, {NewChunkKey(NewId(), 5), 7}};
  const auto read = test::ValueOf(ParseChunks(ChunksText(chunks)));
  EXPECT_EQ(read[1].key, chunks[1].key);
  EXPECT_EQ(read[1].bytes, 7);
  for (const char* bad :
       {"x", "uploads/a:5", "uploads/a:0;", "uploads/a:-1;", "uploads/a:x;", "flights/a:5;", ";", "a;:"})
    EXPECT_FALSE(ParseChunks(bad)) << bad;
  EXPECT_EQ(WholeIn(WholeText(std::string(26, '0'))), std::string(26, '0'));
  EXPECT_EQ(WholeIn("=../x"), "");
}

}  // namespace
}  // namespace skyquilt::storage
