// The same tests over the folder and over S3 (s3rver from npm, tests/e2e/s3_store.py; skipped where there is
// no node).
#include "storage/blobs/blob_store.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <map>
#include <random>
#include <thread>

#include "core/base/parallel_for.h"
#include "storage/blobs/folder_blobs.h"
#include "storage/blobs/range_cache.h"
#include "storage/blobs/s3_blobs.h"
#include "storage/blobs/sha256.h"
#include "storage/db/ids.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

// The program beside this one, for as long as this one lives.
class StoreOfObjects {
 public:
  static StoreOfObjects& Get() {
    static StoreOfObjects store;
    return store;
  }
  const std::string& endpoint() const { return endpoint_; }
  const std::string& why_not() const { return why_not_; }

 private:
  StoreOfObjects() {
    int to[2], from[2];
    if (pipe(to) != 0 || pipe(from) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      dup2(to[0], STDIN_FILENO);
      dup2(from[1], STDOUT_FILENO);
      dup2(from[1], STDERR_FILENO);
      for (const int fd : {to[0], to[1], from[0], from[1]}) close(fd);
      execl("/bin/sh", "sh", "-c", "exec " SKYQUILT_S3_STORE, nullptr);
      _exit(127);
    }
    close(to[0]);
    close(from[1]);
    stop_ = to[1];
    std::string line;
    char c = 0;
    while (read(from[0], &c, 1) == 1 && c != '\n') line += c;
    (line.starts_with("http://") ? endpoint_ : why_not_) = line;
  }
  ~StoreOfObjects() {
    close(stop_);
    if (pid_ > 0) waitpid(pid_, nullptr, 0);
  }
  pid_t pid_ = 0;
  int stop_ = -1;
  std::string endpoint_, why_not_;
};

std::string RandomBytes(std::size_t count) {
  std::mt19937_64 random(count);
  std::string bytes(count, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

class EachBlobStore : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (GetParam() == std::string("folder")) {
      blobs_ = std::make_unique<FolderBlobs>(folder_ / "data");
      return;
    }
    const StoreOfObjects& store = StoreOfObjects::Get();
    if (store.endpoint().empty()) GTEST_SKIP() << store.why_not();
    const Variable variable = [&](const char* name) -> std::string {
      const std::map<std::string, std::string> variables = {{"AWS_ENDPOINT_URL", store.endpoint()},
                                                            {"AWS_ACCESS_KEY_ID", "S3RVER"},
                                                            {"AWS_SECRET_ACCESS_KEY", "S3RVER"}};
      const auto found = variables.find(name);
      return found == variables.end() ? "" : found->second;
    };
    const std::string address = "s3://skyquilt-test/" + NewId();
    const auto open = [&](const char* cache, ProofOfBlob proof) {
      return std::make_unique<S3Blobs>(
          std::make_unique<S3Client>(*ReadS3Settings(address, variable), variable),
          *LocalCache::Open(folder_ / cache, std::int64_t{1} << 30), std::move(proof));
    };
    auto s3 = open("cache", [this](const std::string& key) -> Result<std::optional<std::string>> {
      const auto found = published_.find(key);
      return found == published_.end() ? std::nullopt : std::optional(found->second);
    });
    other_ = open("other cache", {});
    s3_ = s3.get();
    blobs_ = std::move(s3);
  }
  fs::path FileOf(const std::string& bytes) {
    const fs::path path = folder_ / ("file-" + NewId());
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

  test::TemporaryFolder folder_;
  std::unique_ptr<BlobStore> blobs_;
  S3Blobs* s3_ = nullptr;
  std::unique_ptr<S3Blobs> other_;                // of somebody who has the store's key alone
  std::map<std::string, std::string> published_;  // SHA-256 by key, as the catalogue has them
};

TEST_P(EachBlobStore, GivesBackWhatWasPut) {
  const std::string bytes = RandomBytes(100'000);
  const fs::path file = FileOf(bytes);
  for (const char* key : {"flights/a/files/x", "flights/a b=c&d+e/r1/é~(1)$.tif"}) {
    ASSERT_TRUE(blobs_->Put(key, file)) << key;
    EXPECT_EQ(test::ValueOf(blobs_->Find(key)).bytes, 100'000);
    EXPECT_EQ(*blobs_->ReadRange(key, 0, 100'000), bytes);
    EXPECT_EQ(*blobs_->ReadRange(key, 99'990, 500), bytes.substr(99'990));
    EXPECT_EQ(*blobs_->ReadRange(key, 500, 10), bytes.substr(500, 10));
    EXPECT_EQ(*blobs_->ReadRange(key, 100'000, 10), "");
    const auto local = test::ValueOf(blobs_->Local(key));
    EXPECT_EQ(test::BytesOf(local.path), bytes);
  }
  EXPECT_EQ(test::BytesOf(file), bytes);
}

TEST_P(EachBlobStore, TakesFilesOfSeveralPartsAndEmptyOnes) {
  const std::string bytes = RandomBytes(static_cast<std::size_t>(2 * kSinglePutBytes) + 12'345);
  ASSERT_TRUE(blobs_->Put("flights/a/r1/mosaic.pmtiles", FileOf(bytes)));
  EXPECT_EQ(blobs_->Find("flights/a/r1/mosaic.pmtiles")->bytes, static_cast<std::int64_t>(bytes.size()));
  EXPECT_TRUE(test::BytesOf(blobs_->Local("flights/a/r1/mosaic.pmtiles")->path) == bytes);
  ASSERT_TRUE(blobs_->Put("flights/a/r1/geo.txt", FileOf("")));
  EXPECT_EQ(blobs_->Find("flights/a/r1/geo.txt")->bytes, 0);
  EXPECT_EQ(test::BytesOf(blobs_->Local("flights/a/r1/geo.txt")->path), "");
}

TEST_P(EachBlobStore, SaysWhatIsNotThere) {
  EXPECT_EQ(blobs_->Find("flights/a/files/x").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(blobs_->ReadRange("flights/a/files/x", 0, 1).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(blobs_->Local("flights/a/files/x").error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(blobs_->Remove("flights/a/files/x"));
  EXPECT_EQ(*blobs_->RemoveBelow("flights/a/"), 0);
  EXPECT_TRUE(blobs_->List("flights/")->empty());
}

TEST_P(EachBlobStore, ListsByPrefix) {
  const fs::path file = FileOf("x");
  for (const char* key :
       {"flights/b/r2/t", "flights/b/files/1", "flights/b/r10/t", "flights/a/files/2", "flights/ab/x"})
    ASSERT_TRUE(blobs_->Put(key, file));
  const auto keys = [&](const std::string& prefix) {
    std::string all;
    const auto listed = blobs_->List(prefix);
    for (const BlobInfo& blob : *listed) all += blob.key + " ";
    return all;
  };
  EXPECT_EQ(keys("flights/b/"), "flights/b/files/1 flights/b/r10/t flights/b/r2/t ");
  EXPECT_EQ(keys("flights/b/r2/"), "flights/b/r2/t ");
  EXPECT_EQ(keys("flights/a"), "flights/a/files/2 flights/ab/x ");
}

TEST_P(EachBlobStore, ListsMoreThanAPage) {
  const fs::path file = FileOf("x");
  constexpr int kCount = 1'100;
  ParallelFor(kCount, 8, [&](std::size_t i) {
    EXPECT_TRUE(blobs_->Put("flights/a/files/" + std::to_string(i), file)) << i;
  });
  EXPECT_EQ(blobs_->List("flights/a/")->size(), kCount);
  EXPECT_EQ(test::ValueOf(blobs_->RemoveBelow("flights/a/")), kCount);
  EXPECT_TRUE(blobs_->List("flights/")->empty());
}

TEST_P(EachBlobStore, RemovesOneOrAllBelowAndNothingBeside) {
  const fs::path file = FileOf("x");
  for (const char* key : {"flights/a/files/1", "flights/a/files/2", "flights/ab/files/1"})
    ASSERT_TRUE(blobs_->Put(key, file));
  ASSERT_TRUE(blobs_->Local("flights/a/files/1"));
  ASSERT_TRUE(blobs_->Remove("flights/a/files/1"));
  EXPECT_EQ(blobs_->Local("flights/a/files/1").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(*blobs_->RemoveBelow("flights/a/"), 1);
  EXPECT_EQ(blobs_->List("")->size(), 1U);
}

TEST_P(EachBlobStore, PutsIfAbsentOnce) {
  ASSERT_TRUE(blobs_->PutIfAbsent("skyquilt-data.json", "first"));
  EXPECT_EQ(test::ErrorOf(blobs_->PutIfAbsent("skyquilt-data.json", "second")).code, ErrorCode::kConflict);
  EXPECT_EQ(*blobs_->ReadRange("skyquilt-data.json", 0, 100), "first");
}

TEST_P(EachBlobStore, ServesThreadsSideBySide) {
  std::vector<std::thread> threads;
  std::atomic<int> wrong{0};
  for (int thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&, thread] {
      const std::string bytes = RandomBytes(10'000 + static_cast<std::size_t>(thread));
      const fs::path file = FileOf(bytes);
      for (int i = 0; i < 20; ++i) {
        const std::string key = "flights/" + std::to_string(thread) + "/files/" + std::to_string(i);
        if (!blobs_->Put(key, file) || *blobs_->ReadRange(key, 0, 20'000) != bytes) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

// Whoever has such an address needs no keys. (That it is good for nothing else is the signature's matter.)
TEST_P(EachBlobStore, GivesNothingButWhatWasPublished) {
  if (s3_ == nullptr) GTEST_SKIP() << "who may write to the folder is the server";
  const std::string map = "flights/f/r1/mosaic.pmtiles", report = "flights/f/r1/report.json";
  const std::string sums_key = RangeSumsKey(map);
  const fs::path file = FileOf(RandomBytes(700'000)), another = FileOf(RandomBytes(700'001));
  Sha256Sum sums;
  sums.Add(*RangeSumsOfFile(file));
  published_ = {{map, *Sha256OfFile(file)}, {sums_key, sums.Finish()}, {report, *Sha256OfFile(file)}};
  const auto read = [&] { return s3_->ReadNear(map, 300'000, 1'000); };
  // With sums and checksums of its own, all of which fit together.
  ASSERT_TRUE(other_->Put(map, another));
  ASSERT_TRUE(other_->Put(report, another));
  ASSERT_TRUE(other_->ReadNear(map, 300'000, 1'000));
  EXPECT_EQ(read().error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(s3_->Local(map).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(s3_->Local(report).error().code, ErrorCode::kCorrupt);
  // Without any.
  ASSERT_TRUE(other_->Remove(sums_key));
  EXPECT_EQ(read().error().code, ErrorCode::kUnavailable);
  // With the sums of the map, which are no secret.
  ASSERT_TRUE(other_->Put(map, file));
  const std::string bytes = *other_->ReadRange(sums_key, 0, 1'000);
  ASSERT_TRUE(other_->Put(map, another));
  ASSERT_TRUE(other_->Put(sums_key, FileOf(bytes)));
  EXPECT_EQ(read().error().code, ErrorCode::kUnavailable);
  // Once it is put back it is read again: nothing of the others was kept.
  ASSERT_TRUE(other_->Put(map, file));
  ASSERT_TRUE(other_->Put(report, file));
  EXPECT_EQ(test::ValueOf(read()), test::BytesOf(file).substr(300'000, 1'000));
  EXPECT_TRUE(s3_->Local(map));
  EXPECT_TRUE(s3_->Local(report));
  // Of maps of which nothing is known the store's word counts, and a name that was not published is refused.
  ASSERT_TRUE(other_->Put("flights/f/r2/mosaic.pmtiles", another));
  EXPECT_TRUE(s3_->ReadNear("flights/f/r2/mosaic.pmtiles", 0, 10));
  published_["flights/f/r1/layer_error.mbtiles"] = "";
  ASSERT_TRUE(other_->Put("flights/f/r1/layer_error.mbtiles", another));
  EXPECT_EQ(s3_->Local("flights/f/r1/layer_error.mbtiles").error().code, ErrorCode::kCorrupt);
}

INSTANTIATE_TEST_SUITE_P(Blobs, EachBlobStore, testing::Values("folder", "s3"),
                         [](const auto& one) { return std::string(one.param); });

TEST(FolderBlobs, AListThatCannotBeReadIsNoEmptyOne) {
  const test::TemporaryFolder folder;
  FolderBlobs blobs(folder.path());
  EXPECT_TRUE(test::ValueOf(blobs.List("flights/")).empty()) << "it is not there yet";
  std::ofstream(folder.path() / "flights") << "no folder";
  const Result<std::vector<BlobInfo>> listed = blobs.List("flights/");
  ASSERT_FALSE(listed);
  EXPECT_EQ(listed.error().code, ErrorCode::kIo) << listed.error().message;
}

TEST(FolderBlobs, APutThatFailsLeavesNoCopy) {
  test::TemporaryFolder folder;
  FolderBlobs blobs(folder.path());
  std::ofstream(folder / "file") << "bytes";
  const fs::path files = folder / "flights/a/files";
  fs::create_directories(files / "x/in the way");
  EXPECT_FALSE(blobs.Put("flights/a/files/x", folder / "file"));
  EXPECT_FALSE(blobs.Put("flights/a/files/y", folder / "no such file"));
  EXPECT_EQ(blobs.PutIfAbsent("flights/a/files/x", "bytes").error().code, ErrorCode::kConflict);
  EXPECT_EQ(std::distance(fs::directory_iterator(files), fs::directory_iterator()), 1);
}

TEST(PartBytesFor, StaysBelowTenThousandParts) {
  EXPECT_EQ(PartBytesFor(1), kSinglePutBytes);
  const std::int64_t largest = std::int64_t{5} << 40;
  EXPECT_LT((largest + PartBytesFor(largest) - 1) / PartBytesFor(largest), 10'000);
}

}  // namespace
}  // namespace skyquilt::storage
