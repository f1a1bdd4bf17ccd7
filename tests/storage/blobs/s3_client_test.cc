// S3Client against answers that a real store gives once in a long while.
#include "storage/blobs/s3/s3_client.h"

#include <gtest/gtest.h>

#include <map>

#include "storage/blobs/sha256.h"
#include "tests/storage/blobs/scripted_server.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

using test::HttpText;
using test::ScriptedServer;

std::string Refusal(const std::string& code, const std::string& more = "") {
  return "<Error><Code>" + code + "</Code><Message>m</Message>" + more + "</Error>";
}

class ScriptedStore {
 public:
  explicit ScriptedStore(ScriptedServer::Script script, int attempts = S3Settings().attempts)
      : server_(std::move(script)) {
    const std::map<std::string, std::string> variables = {{"AWS_ENDPOINT_URL", server_.Endpoint()},
                                                          {"AWS_ACCESS_KEY_ID", "AKEY"},
                                                          {"AWS_SECRET_ACCESS_KEY", "very secret"}};
    const Variable variable = [variables](const char* name) {
      const auto found = variables.find(name);
      return found == variables.end() ? std::string() : found->second;
    };
    S3Settings settings = *ReadS3Settings("s3://maps/p", variable);
    settings.stall_patience = std::chrono::seconds(1);
    settings.attempts = attempts;
    client_ = std::make_unique<S3Client>(std::move(settings), variable);
  }
  S3Client& operator*() { return *client_; }
  S3Client* operator->() { return client_.get(); }
  std::vector<std::string> requests() const { return server_.requests(); }

 private:
  ScriptedServer server_;
  std::unique_ptr<S3Client> client_;
};

// Pauses double: two stores that fail three times each are sooner done than one that fails six times.
TEST(S3Client, TriesAgainAfterWhatMayPass) {
  for (const std::vector<int>& bad : {std::vector<int>{500, 503, 0}, std::vector<int>{429, 502, 504}}) {
    ScriptedStore store([&](int n, const std::string&) -> std::string {
      if (n >= 3) return HttpText(200, "", "ETag: \"e\"\r\n");
      const int status = bad.at(static_cast<std::size_t>(n));
      return status == 0 ? "" : HttpText(status, Refusal("SlowDown"));
    });
    EXPECT_TRUE(store->Put("k", "bytes", {}));
    ASSERT_EQ(store.requests().size(), 4U);
    EXPECT_TRUE(store.requests()[3].ends_with("\r\n\r\nbytes"));
    EXPECT_TRUE(store.requests()[3].starts_with("PUT /maps/p/k HTTP/1.1"));
  }
}

TEST(S3Client, GivesUpInTheEndAndSaysThatItMayComeBack) {
  ASSERT_EQ(S3Settings().attempts, 6);  // whose pauses are seconds
  ScriptedStore store([](int, const std::string&) { return HttpText(503, Refusal("SlowDown")); }, 3);
  const Error put = test::ErrorOf(store->Put("k", "bytes", {}));
  EXPECT_EQ(put.code, ErrorCode::kUnavailable);
  EXPECT_NE(put.message.find("Try again later"), std::string::npos);
  EXPECT_EQ(store.requests().size(), 3U);
}

TEST(S3Client, AsksOnceWhereItIsRefusedAndTellsNoSecret) {
  ScriptedStore store(
      [](int, const std::string&) { return HttpText(403, Refusal("SignatureDoesNotMatch")); });
  const Error got = test::ErrorOf(store->Get("k", 0, 10));
  EXPECT_EQ(got.code, ErrorCode::kForbidden);
  EXPECT_NE(got.message.find("AWS_ACCESS_KEY_ID"), std::string::npos);
  EXPECT_EQ((got.message + got.detail).find("very secret"), std::string::npos);
  EXPECT_EQ(store.requests().size(), 1U);
}

// Keys that were taken away, a bucket that was removed: photos are neither forbidden to their users nor gone.
TEST(S3Client, IsUnavailableWhereWhatWorkedIsRefused) {
  ScriptedStore store([](int n, const std::string&) {
    return n == 0 ? HttpText(200)
                  : HttpText(n == 1 ? 403 : 404, Refusal(n == 1 ? "AccessDenied" : "NoSuchBucket"));
  });
  EXPECT_TRUE(store->Delete("k"));
  EXPECT_EQ(store->List("", "").error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(store->List("", "").error().code, ErrorCode::kUnavailable);
}

TEST(S3Client, SaysThatTheBucketIsMissing) {
  ScriptedStore store([](int, const std::string&) { return HttpText(404, Refusal("NoSuchBucket")); });
  const auto listed = store->List("", "");
  EXPECT_EQ(listed.error().code, ErrorCode::kNotFound);
  EXPECT_NE(listed.error().message.find("bucket \"maps\""), std::string::npos);
}

TEST(S3Client, SignsByTheStoresClockWhereItsOwnIsWrong) {
  ScriptedStore store([](int n, const std::string&) {
    if (n == 0)
      return HttpText(403, Refusal("RequestTimeTooSkewed"), "Date: Tue, 05 Jan 2044 10:00:00 GMT\r\n");
    return HttpText(200, "", "ETag: \"e\"\r\n");
  });
  EXPECT_TRUE(store->Put("k", "bytes", {}));
  EXPECT_EQ(store.requests()[0].find("x-amz-date: 20440105"), std::string::npos);
  EXPECT_NE(store.requests()[1].find("x-amz-date: 20440105"), std::string::npos);
}

// The answer to a HEAD has no body: as where the clock was put right since the store's was learnt.
TEST(S3Client, LearnsWhyAHeadIsRefused) {
  const std::string date = "Date: Tue, 05 Jan 2044 10:00:00 GMT\r\n";
  ScriptedStore store([&](int n, const std::string&) {
    if (n == 0) return HttpText(403, "", date);
    return n == 1 ? HttpText(403, Refusal("RequestTimeTooSkewed"), date) : HttpText(200);
  });
  EXPECT_TRUE(store->Head("k"));
  const std::vector<std::string> requests = store.requests();
  ASSERT_EQ(requests.size(), 3U);
  EXPECT_TRUE(requests[1].starts_with("GET /maps/p/k HTTP/1.1")) << requests[1];
  EXPECT_TRUE(requests[2].starts_with("HEAD /maps/p/k HTTP/1.1")) << requests[2];
  EXPECT_NE(requests[2].find("x-amz-date: 20440105"), std::string::npos);
}

TEST(S3Client, SaysWhyAHeadIsRefused) {
  ScriptedStore store([](int n, const std::string&) {
    return n == 0 ? HttpText(403) : HttpText(403, Refusal("InvalidAccessKeyId"));
  });
  EXPECT_NE(test::ErrorOf(store->Head("k")).message.find("InvalidAccessKeyId"), std::string::npos);
  EXPECT_EQ(store.requests().size(), 2U);
}

TEST(S3Client, SignsForTheRegionThatTheBucketIsIn) {
  ScriptedStore store([](int n, const std::string&) {
    if (n == 0) return HttpText(400, Refusal("AuthorizationHeaderMalformed", "<Region>eu-west-1</Region>"));
    return HttpText(200, "", "ETag: \"e\"\r\n");
  });
  EXPECT_TRUE(store->Put("k", "bytes", {}));
  EXPECT_NE(store.requests()[1].find("/eu-west-1/s3/aws4_request"), std::string::npos);
}

TEST(S3Client, ReadsARangeAgainThatBrokeOff) {
  ScriptedStore store([](int n, const std::string&) {
    const std::string whole = HttpText(206, "0123456789", "ETag: \"e\"\r\n");
    return n == 0 ? whole.substr(0, whole.size() - 4) : whole;
  });
  EXPECT_EQ(*store->Get("k", 5, 10), "0123456789");
  EXPECT_NE(store.requests()[0].find("Range: bytes=5-14"), std::string::npos);
}

TEST(S3Client, ReadsARangeAgainThatIsShorterThanTheObjectAllows) {
  ScriptedStore store([](int n, const std::string&) {
    const std::string range = "Content-Range: bytes 5-14/100\r\n";
    return n == 0 ? HttpText(206, "0123", range) : HttpText(206, "0123456789", range);
  });
  EXPECT_EQ(*store->Get("k", 5, 10), "0123456789");
  ScriptedStore end(
      [](int, const std::string&) { return HttpText(206, "01", "Content-Range: bytes 98-99/100\r\n"); });
  EXPECT_EQ(*end->Get("k", 98, 10), "01");
}

TEST(S3Client, WaitsLongerEachTimeForAStoreThatIsSlowToStore) {
  ScriptedStore store([](int, const std::string&) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1'500));
    return HttpText(200, "", "ETag: \"e\"\r\n");
  });
  const auto put = store->Put("k", "bytes", {});
  EXPECT_TRUE(put) << put.error().message;
}

TEST(S3Client, BelievesNoStoreThatSendsMoreThanWasAskedFor) {
  ScriptedStore store([](int, const std::string&) { return HttpText(206, std::string(100, 'x')); });
  EXPECT_EQ(store->Get("k", 0, 10).error().code, ErrorCode::kCorrupt);
}

std::string TagsOf(const std::string& bytes) {
  return "ETag: \"e\"\r\nx-amz-meta-sha256: " + Sha256Hex(bytes) + "\r\n";
}

TEST(S3Client, GoesOnWithAFileWhereItBrokeOff) {
  const std::string bytes(50'000, 'q');
  ScriptedStore store([&](int n, const std::string& request) {
    if (n == 0) return HttpText(503, Refusal("SlowDown"));
    const std::size_t range = request.find("bytes=");
    const std::size_t from = range == std::string::npos ? 0 : std::stoul(request.substr(range + 6));
    std::string answer = HttpText(from == 0 ? 200 : 206, bytes.substr(from), TagsOf(bytes));
    if (n < 3) answer.resize(answer.size() - 20'000);
    return answer;
  });
  const test::TemporaryFolder folder;
  const auto got = test::ValueOf(store->GetToFile("k", folder / "file"));
  EXPECT_EQ(got.bytes, 50'000);
  EXPECT_EQ(got.etag, "\"e\"");
  EXPECT_EQ(test::BytesOf(folder / "file"), bytes);
  const std::vector<std::string> requests = store.requests();
  ASSERT_EQ(requests.size(), 4U);
  EXPECT_EQ(requests[1].find("Range:"), std::string::npos);
  EXPECT_NE(requests[2].find("Range: bytes=30000-49999"), std::string::npos);
  EXPECT_NE(requests[3].find("Range: bytes=30000-49999"), std::string::npos);  // of the third nothing came
  EXPECT_NE(requests[3].find("If-Match: \"e\""), std::string::npos);
}

TEST(S3Client, FetchesAFileByOneRequest) {
  for (const std::string& bytes : {std::string(), std::string("few"), std::string(3 << 20, 'x')}) {
    ScriptedStore store([&](int, const std::string&) { return HttpText(200, bytes, TagsOf(bytes)); });
    const test::TemporaryFolder folder;
    ASSERT_TRUE(store->GetToFile("k", folder / "file"));
    EXPECT_EQ(std::filesystem::file_size(folder / "file"), bytes.size());
    EXPECT_EQ(store.requests().size(), 1U);
  }
}

TEST(S3Client, RefusesAFileThatHasNoLengthOrIsNotThere) {
  const test::TemporaryFolder folder;
  ScriptedStore endless([](int, const std::string&) {
    return "HTTP/1.1 200 OK\r\nConnection: close\r\nETag: \"e\"\r\n\r\n" + std::string(1000, 'x');
  });
  EXPECT_EQ(endless->GetToFile("k", folder / "file").error().code, ErrorCode::kCorrupt);
  ScriptedStore empty([](int, const std::string&) { return HttpText(404, Refusal("NoSuchKey")); });
  EXPECT_EQ(empty->GetToFile("k", folder / "file").error().code, ErrorCode::kNotFound);
}

TEST(S3Client, RefusesAFileWithOtherBytesThanItsWriterStated) {
  ScriptedStore store([](int, const std::string&) { return HttpText(200, "wrong", TagsOf("right")); });
  const test::TemporaryFolder folder;
  EXPECT_EQ(store->GetToFile("k", folder / "file").error().code, ErrorCode::kCorrupt);
}

TEST(S3Client, KnowsItsOwnConditionalPutWhoseAnswerWasLost) {
  std::string writer;
  ScriptedStore store([&](int n, const std::string& request) -> std::string {
    if (n == 0) return HttpText(404);
    if (n == 1) {
      const std::size_t at = request.find("x-amz-meta-writer: ");
      writer = request.substr(at + 19, 26);
      EXPECT_NE(request.find("If-None-Match: *"), std::string::npos);
      return "";
    }
    if (n == 2) return HttpText(412, Refusal("PreconditionFailed"));
    return HttpText(200, "", "x-amz-meta-writer: " + writer + "\r\n");
  });
  EXPECT_TRUE(store->Put("k", "bytes", {"", true}));
}

TEST(S3Client, LosesAConditionalPutToWhoeverWasFirst) {
  ScriptedStore store([](int n, const std::string&) {
    return n == 0 ? HttpText(404) : HttpText(412, Refusal("PreconditionFailed"));
  });
  EXPECT_EQ(store->Put("k", "bytes", {"", true}).error().code, ErrorCode::kConflict);
}

// As OpenStack Swift's S3 interface.
class StoreWithoutConditions {
 public:
  explicit StoreWithoutConditions(std::string last_writer = "")
      : last_writer_(std::move(last_writer)), store_([this](int n, const std::string& request) {
          if (n == 0) return HttpText(404);
          if (n == 1) return HttpText(501, Refusal("NotImplemented"));
          if (n == 2) {
            EXPECT_EQ(request.find("If-None-Match"), std::string::npos);
            if (last_writer_.empty())
              last_writer_ = request.substr(request.find("x-amz-meta-writer: ") + 19, 26);
            return HttpText(200);
          }
          return HttpText(200, "", "x-amz-meta-writer: " + last_writer_ + "\r\n");
        }) {}

  Result<void> PutIfAbsent() { return store_->Put("k", "bytes", {"", true}); }
  std::size_t requests() const { return store_.requests().size(); }

 private:
  std::string last_writer_;
  ScriptedStore store_;
};

TEST(S3Client, PutsWhereConditionsAreNotKnownAndLooksWhoWasLast) {
  StoreWithoutConditions alone;
  EXPECT_TRUE(alone.PutIfAbsent());
  EXPECT_EQ(alone.requests(), 4U);
  StoreWithoutConditions raced("01aaaaaaaaaaaaaaaaaaaaaaaa");
  EXPECT_EQ(raced.PutIfAbsent().error().code, ErrorCode::kConflict);
}

TEST(S3Client, DoesNotAskAgainForWhatAStoreDoesNotKnow) {
  ScriptedStore store([](int, const std::string&) { return HttpText(501, Refusal("NotImplemented")); });
  EXPECT_EQ(store->Put("k", "bytes", {}).error().code, ErrorCode::kNotImplemented);
  EXPECT_EQ(store.requests().size(), 1U);
}

TEST(S3Client, SeesAnErrorInsideACompletionThatSays200) {
  ScriptedStore store([](int, const std::string&) { return HttpText(200, Refusal("InternalError")); });
  EXPECT_EQ(test::ErrorOf(store->Complete("k", "u", {{1, "e", 5}}, 5)).code, ErrorCode::kUnavailable);
  EXPECT_EQ(store.requests().size(), 2U);
}

TEST(S3Client, KnowsACompletionWhoseAnswerWasLost) {
  ScriptedStore store([](int n, const std::string&) -> std::string {
    if (n == 0) return "";
    if (n == 1) return HttpText(404, Refusal("NoSuchUpload"));
    return "HTTP/1.1 200 X\r\nContent-Length: 5\r\nConnection: close\r\n\r\n";
  });
  EXPECT_TRUE(store->Complete("k", "u", {{1, "e", 5}}, 5));
}

}  // namespace
}  // namespace skyquilt::storage
