// Quotas at every door, with and without a length; and keys of requests that belong to one token and one
// body.
#include "api/auth/limits.h"
#include "api/http/digest.h"
#include "storage/catalogue/idempotent_answers.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using storage::Scope;

constexpr int kRefused = -static_cast<int>(ErrorCode::kTooLarge);  // while the body came in

struct Fixture {
  SampleService sample;
  Headers small = sample.MakeToken("small", Scope::kUpload, 1000);
  Headers admin = sample.MakeToken("admin", Scope::kAdmin);
  std::string flight = sample.catalogue.AddFlight("field", "{}", storage::Now(), "small")->id;

  Headers With(Headers headers, std::initializer_list<std::pair<const char*, std::string>> more) {
    for (const auto& [name, value] : more) headers.Add(name, value);
    return headers;
  }
  std::string At(const std::string& name) { return "/api/v1/flights/" + flight + "/files/" + name; }
  std::int64_t Held() { return *sample.catalogue.BytesOf("small"); }
  // As a chunked body comes: without a length.
  int SendWithoutLength(Method method, const std::string& target, const std::string& body,
                        const Headers& headers) {
    return sample.Send(method, target, body, headers, false).status;
  }
  std::string FormOf(const std::string& bytes, const std::string& boundary = "b",
                     const std::string& name = "a.jpg") {
    return "--" + boundary + "\r\nContent-Disposition: form-data; name=\"images\"; filename=\"" + name +
           "\"\r\n\r\n" + bytes + "\r\n--" + boundary + "--\r\n";
  }
};

TEST(Quota, HoldsForBodiesWithAndWithoutALength) {
  Fixture f;
  const std::string many(2000, 'x');
  Response declared = f.sample.Send(Method::kPut, f.At("a.jpg"), many, f.small);
  EXPECT_EQ(declared.status, 413);
  EXPECT_NE(declared.body.find("may hold 1.0 kB"), std::string::npos) << declared.body;
  EXPECT_EQ(f.SendWithoutLength(Method::kPut, f.At("a.jpg"), many, f.small), kRefused);
  EXPECT_EQ(f.SendWithoutLength(Method::kPut, f.At("a.jpg"), std::string(600, 'x'), f.small), 201);
  EXPECT_EQ(f.SendWithoutLength(Method::kPut, f.At("b.jpg"), std::string(600, 'x'), f.small), kRefused);
  // Also where an admin brings them: they are the flight's.
  EXPECT_EQ(f.SendWithoutLength(Method::kPut, f.At("b.jpg"), std::string(600, 'x'), f.admin), kRefused);
  EXPECT_EQ(f.SendWithoutLength(Method::kPut, f.At("b.jpg"), std::string(400, 'x'), f.small), 201);
  EXPECT_EQ(f.Held(), 1000);
  EXPECT_EQ(f.SendWithoutLength(Method::kPut, f.At("c.jpg"), "x", f.small), kRefused);
  // What is deleted makes room.
  EXPECT_EQ(f.sample.Send(Method::kDelete, f.At("a.jpg"), "", f.small).status, 204);
  EXPECT_EQ(f.SendWithoutLength(Method::kPut, f.At("c.jpg"), std::string(600, 'x'), f.small), 201);
  EXPECT_TRUE(std::filesystem::is_empty(f.sample.dir().Incoming()));
}

TEST(Quota, HoldsForForms) {
  Fixture f;
  const Headers form = f.With(f.small, {{"Content-Type", "multipart/form-data; boundary=b"}});
  const std::string files = "/api/v1/flights/" + f.flight + "/files";
  EXPECT_EQ(f.sample.Send(Method::kPost, files, f.FormOf(std::string(2000, 'x')), form).status, kRefused);
  EXPECT_EQ(f.sample.Send(Method::kPost, "/api/v1/flights", f.FormOf(std::string(2000, 'x')), form).status,
            kRefused);
  EXPECT_EQ(f.sample.Send(Method::kPost, files, f.FormOf(std::string(900, 'x')), form).status, 201);
  EXPECT_EQ(f.sample.Send(Method::kPost, "/api/v1/flights", f.FormOf(std::string(200, 'x')), form).status,
            kRefused);
  EXPECT_EQ(f.Held(), 900);
  // The node's clients hear of it at the end.
  const Response whole = f.sample.Send(Method::kPost, "/task/new", f.FormOf(std::string(200, 'x')), form);
  EXPECT_EQ(whole.status, 200);
  EXPECT_NE(whole.body.find("may hold 1.0 kB"), std::string::npos) << whole.body;
  EXPECT_EQ(f.Held(), 900);
  EXPECT_EQ(f.sample.catalogue.FlightIds()->size(), 1u);
}

TEST(Quota, HoldsForResumableUploads) {
  Fixture f;
  const std::string metadata =
      "flight " + EncodeBase64(f.flight) + ",filename " + EncodeBase64(std::string("a.jpg"));
  const auto create = [&](const char* name, const char* value) {
    return f.sample.Send(
        Method::kPost, "/api/v1/uploads", "",
        f.With(f.small, {{"Tus-Resumable", "1.0.0"}, {"Upload-Metadata", metadata}, {name, value}}));
  };
  const auto patch = [&](const std::string& at, const char* offset, std::size_t bytes,
                         const char* length = "") {
    Headers headers = f.With(f.small, {{"Tus-Resumable", "1.0.0"},
                                       {"Upload-Offset", offset},
                                       {"Content-Type", "application/offset+octet-stream"}});
    if (*length != '\0') headers.Add("Upload-Length", length);
    return f.sample.Send(Method::kPatch, at, std::string(bytes, 'x'), headers).status;
  };
  EXPECT_EQ(create("Upload-Length", "1001").status, 413);
  const Response deferred = create("Upload-Defer-Length", "1");
  EXPECT_EQ(deferred.status, 201);
  const std::string at(deferred.headers.Find("Location"));
  EXPECT_EQ(patch(at, "0", 600), 204);
  EXPECT_EQ(patch(at, "600", 600), kRefused);
  EXPECT_EQ(create("Upload-Length", "500").status, 413);
  EXPECT_EQ(patch(at, "600", 100, "2000"), 413);
  EXPECT_EQ(patch(at, "600", 300, "900"), 204);
  EXPECT_EQ(f.Held(), 900);
  EXPECT_EQ(create("Upload-Length", "100").status, 201);
  EXPECT_EQ(create("Upload-Length", "1").status, 413);
}

TEST(Quota, CountsWhatSeveralBringAtOnce) {
  Fixture f;
  auto one = *IncomingBytes::Into(f.sample.service(), f.flight);
  {
    auto two = *IncomingBytes::Into(f.sample.service(), f.flight);
    EXPECT_TRUE(one.Take(600));
    EXPECT_TRUE(two.Take(400));
    EXPECT_FALSE(two.Take(1));
    EXPECT_FALSE(one.Take(1));
    EXPECT_EQ(**one.Room(), 0);
  }
  // What broke off is given back.
  EXPECT_TRUE(one.Take(400));
  auto free = *IncomingBytes::For(f.sample.service(), "admin");
  EXPECT_TRUE(free.Take(std::int64_t{1} << 50));
  EXPECT_FALSE(*free.Room());
}

TEST(Quota, HoldsForWhatIsInArchives) {
  Fixture f;
  std::int64_t room = 0;
  f.sample.service().unpack = [&](const auto& store, const auto& flight, const auto&,
                                  std::int64_t max_bytes) {
    room = max_bytes;
    auto upload = *store.Begin(flight, 0);
    const std::vector<std::uint8_t> bytes(static_cast<std::size_t>(1200), 1);
    EXPECT_TRUE(upload.Write(bytes));
    return Result<std::vector<storage::UnpackedFile>>({{{"in.jpg", *upload.Finish(), 1200}, std::nullopt}});
  };
  const Response refused = f.sample.Send(Method::kPut, f.At("a.zip"), std::string(300, 'x'), f.small);
  EXPECT_EQ(refused.status, 413) << refused.body;
  EXPECT_EQ(room, 1000);
  EXPECT_EQ(f.Held(), 0);
  EXPECT_TRUE(std::filesystem::is_empty(f.sample.dir().Files(f.flight)));
}

TEST(IdempotencyKeys, BelongToTheTokenThatSentThem) {
  Fixture f;
  const Headers other = f.sample.MakeToken("other", Scope::kUpload);
  const auto make = [&](const Headers& who) {
    return f.sample.Send(Method::kPost, "/api/v1/flights", "{}",
                         f.With(who, {{"Idempotency-Key", "key"}, {"Content-Type", "application/json"}}));
  };
  const Response first = make(f.small);
  const Response second = make(other);
  EXPECT_EQ(second.status, 201);
  EXPECT_FALSE(second.headers.Has("Idempotency-Replayed"));
  EXPECT_NE(second.headers.Find("Location"), first.headers.Find("Location"));
  EXPECT_EQ(make(f.small).headers.Find("Idempotency-Replayed"), "true");
}

TEST(IdempotencyKeys, AreOfOneFormWhateverItsBoundary) {
  Fixture f;
  const auto send = [&](const std::string& bytes, const std::string& boundary,
                        const std::string& name = "a.jpg") {
    return f.sample.Send(Method::kPost, "/api/v1/flights", f.FormOf(bytes, boundary, name),
                         f.With(f.admin, {{"Idempotency-Key", "key"},
                                          {"Content-Type", "multipart/form-data; boundary=" + boundary}}));
  };
  const Response first = send("one", "b");
  EXPECT_EQ(first.status, 202) << first.body;
  const Response again = send("one", "other");
  EXPECT_EQ(again.headers.Find("Idempotency-Replayed"), "true");
  EXPECT_EQ(again.body, first.body);
  EXPECT_EQ(send("two", "b").status, 422);
  EXPECT_EQ(send("one", "b", "b.jpg").status, 422);
  const Response by_json =
      f.sample.Send(Method::kPost, "/api/v1/flights", "{}",
                    f.With(f.admin, {{"Idempotency-Key", "key"}, {"Content-Type", "application/json"}}));
  EXPECT_EQ(by_json.status, 422);
  EXPECT_EQ(f.sample.catalogue.FlightIds()->size(), 2u);  // that of the fixture, and the first form's
}

TEST(IdempotencyKeys, AreForgottenOldestFirstWhereOneTokenSendsTooMany) {
  using storage::IdempotentAnswers;
  SampleService sample;
  storage::CatalogueDb& db = sample.service().db;
  IdempotentAnswers answers(db);
  const storage::Time now = db.ages().Now();
  ASSERT_TRUE(answers.Keep({"other", "key-1", "POST /x"}, {}, now - std::chrono::hours(1)));
  ASSERT_TRUE(db.Lock()->Change(
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<?1) INSERT INTO idempotent_answer"
      " SELECT 'link', 'key-'||i, 'POST /x', x'00', 202, '', '{}', ?2+i FROM n",
      IdempotentAnswers::kMaxOfOwner, storage::ToUs(now - std::chrono::minutes(1))));
  ASSERT_TRUE(answers.Keep({"link", "newest", "POST /x"}, {}, now));
  const auto is_kept = [&](const std::string& owner, const std::string& key) {
    return answers.Find({owner, key, "POST /x"}, now)->has_value();
  };
  EXPECT_FALSE(is_kept("link", "key-1"));
  EXPECT_TRUE(is_kept("link", "key-2"));
  EXPECT_TRUE(is_kept("link", "newest"));
  EXPECT_TRUE(is_kept("other", "key-1"));
}

}  // namespace
}  // namespace skyquilt::api
