// Files of a map that are sent out of a store.
#include <gtest/gtest.h>

#include "api/downloads/send_file.h"
#include "storage/blobs/range_cache.h"
#include "storage/blobs/sha256.h"
#include "tests/storage/blobs/far_folder.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::api {
namespace {

constexpr const char* kMapKey = "flights/f/r1/mosaic.mbtiles";

class SentMap : public testing::Test {
 protected:
  void SetUp() override {
    for (std::size_t i = 0; i < bytes_.size(); ++i) bytes_[i] = static_cast<char>(i * 2'654'435'761U >> 13);
    std::ofstream(folder_ / "file", std::ios::binary) << bytes_;
    ASSERT_TRUE(far_.Put(kMapKey, folder_ / "file"));
  }
  struct Got {
    int status = 0;
    std::string body;
    std::optional<Error> error;
  };
  Got Get(const std::string& range = "") {
    Request request;
    if (!range.empty()) request.headers.Add("Range", range);
    Result<Response> response = SendBlob(request, far_, kMapKey, "application/x-sqlite3", "\"tag\"");
    if (!response) return {0, {}, response.error()};
    Got got{response->status, {}, {}};
    std::vector<std::uint8_t> slice(100'000);
    while (true) {
      const Result<std::size_t> read = response->source->Read(slice);
      if (!read) got.error = read.error();
      if (!read || *read == 0) return got;
      got.body.append(slice.begin(), slice.begin() + static_cast<std::ptrdiff_t>(*read));
    }
  }

  test::TemporaryFolder folder_;
  test::FarFolder far_{folder_ / "far"};
  std::string bytes_ = std::string(std::size_t{9} << 20, '\0');
};

TEST_F(SentMap, IsTheWholeFileWhereNothingOrTheSameIsKnown) {
  for (const bool is_known : {false, true}) {
    if (is_known) far_.known[kMapKey] = *storage::Sha256OfFile(folder_ / "file");
    const Got whole = Get();
    EXPECT_FALSE(whole.error);
    EXPECT_EQ(whole.status, 200);
    EXPECT_TRUE(whole.body == bytes_);
    const Got part = Get("bytes=5000000-5000099");
    EXPECT_EQ(part.status, 206);
    EXPECT_TRUE(part.body == bytes_.substr(5'000'000, 100));
  }
}

TEST_F(SentMap, IsNotFetchedForAPartWhereSumsOfRangesAreKnown) {
  const std::string sums = storage::RangeSumsKey(kMapKey);
  far_.known = {{kMapKey, *storage::Sha256OfFile(folder_ / "file")}, {sums, std::string(64, '0')}};
  const Got part = Get("bytes=4000000-8999999");
  EXPECT_EQ(part.status, 206);
  EXPECT_TRUE(part.body == bytes_.substr(4'000'000, 5'000'000));
  EXPECT_TRUE(Get("bytes=0-").body == bytes_);
  EXPECT_TRUE(Get("bytes=nonsense").body == bytes_);
  EXPECT_EQ(far_.fetched, 0);
  EXPECT_EQ(far_.near_reads, 2 + 3 + 3);
  // A map that was published without.
  far_.known[sums] = "";
  EXPECT_TRUE(Get("bytes=4000000-8999999").body == bytes_.substr(4'000'000, 5'000'000));
  EXPECT_EQ(far_.fetched, 1);
}

TEST_F(SentMap, EndsBeforeItsEndWhereItIsAnother) {
  far_.known[kMapKey] = std::string(64, '0');
  const Got got = Get();
  ASSERT_TRUE(got.error);
  EXPECT_EQ(got.error->code, ErrorCode::kUnavailable);
  EXPECT_LT(got.body.size(), bytes_.size());
}

}  // namespace
}  // namespace skyquilt::api
