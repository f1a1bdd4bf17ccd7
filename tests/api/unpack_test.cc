// Archives that become their files, also where a server died meanwhile.
#include "api/uploads/unpack.h"

#include <cstdint>
#include <iterator>
#include <string_view>

#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

std::string StoreBytes(const storage::PhotoStore& store, const std::string& flight, std::string_view text) {
  auto upload = test::ValueOf(store.Begin(flight, 0));
  EXPECT_TRUE(upload.Write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
  return test::ValueOf(upload.Finish());
}

// Whatever archive it is, a.jpg and b.jpg are in it.
Result<std::vector<storage::UnpackedFile>> UnpackTwo(const storage::PhotoStore& store,
                                                     const std::string& flight, const std::filesystem::path&,
                                                     std::int64_t) {
  return std::vector<storage::UnpackedFile>{{{"a.jpg", StoreBytes(store, flight, "one"), 3}, std::nullopt},
                                            {{"b.jpg", StoreBytes(store, flight, "two"), 3}, std::nullopt}};
}

std::vector<std::string> ListedNames(const SampleService& sample, const std::string& flight) {
  const auto files = test::ValueOf(sample.catalogue.ListFiles(flight));
  std::vector<std::string> names;
  for (const storage::StoredFile& file : files) names.push_back(file.name);
  return names;
}

std::ptrdiff_t StoredCount(const SampleService& sample, const std::string& flight) {
  return std::distance(std::filesystem::directory_iterator(sample.dir().Files(flight)), {});
}

// As a server leaves it that is killed at that moment.
void LeaveArchive(SampleService& sample, const std::string& flight) {
  const std::string stored = StoreBytes(sample.service().store, flight, "archive");
  ASSERT_TRUE(sample.catalogue.AddFileUnderFreeName(flight, {"a.zip", stored, 7}, storage::Now()));
}

TEST(Unpack, AnArchiveGoesOnlyWhenItsFilesHaveCome) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  ASSERT_TRUE(sample.service().db.Lock()->Exec(
      "CREATE TRIGGER gone AFTER DELETE ON file WHEN OLD.name='a.zip' BEGIN UPDATE flight SET name="
      "(SELECT group_concat(name) FROM (SELECT name FROM file WHERE flight_id=OLD.flight_id ORDER BY name))"
      " WHERE id=OLD.flight_id; END"));
  sample.service().unpack = UnpackTwo;
  EXPECT_EQ(sample.Send(Method::kPut, "/api/v1/flights/" + flight + "/files/a.zip", "archive").status, 201);
  EXPECT_EQ(sample.catalogue.GetFlight(flight)->name, "a.jpg,b.jpg") << "what was there when it went";
  EXPECT_EQ(ListedNames(sample, flight), (std::vector<std::string>{"a.jpg", "b.jpg"}));
}

TEST(Unpack, AnotherArchiveThatCameUnderItsNameMeanwhileStays) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  sample.service().unpack = [&](const storage::PhotoStore& store, const std::string& of,
                                const std::filesystem::path& path, std::int64_t room) {
    EXPECT_TRUE(sample.catalogue.RemoveFile(of, "a.zip"));
    LeaveArchive(sample, of);
    return UnpackTwo(store, of, path, room);
  };
  EXPECT_EQ(sample.Send(Method::kPut, "/api/v1/flights/" + flight + "/files/a.zip", "archive").status, 201);
  EXPECT_EQ(ListedNames(sample, flight), (std::vector<std::string>{"a.jpg", "a.zip", "b.jpg"}));
}

TEST(Unpack, WhatADeadServerLeftIsUnpackedAtTheStart) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string at = "/api/v1/flights/" + flight + "/files/a.jpg";
  ASSERT_EQ(sample.Send(Method::kPut, at, "one").status, 201);  // came in before
  LeaveArchive(sample, flight);
  sample.service().unpack = UnpackTwo;
  const auto left = test::ValueOf(FindCutOff(sample.service()));
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(test::ValueOf(UnpackCutOff(sample.service(), left[0])), 1u);
  EXPECT_EQ(ListedNames(sample, flight), (std::vector<std::string>{"a.jpg", "a.zip", "b.jpg"}));
  ASSERT_TRUE(RemoveCutOff(sample.service(), left[0]));
  EXPECT_EQ(ListedNames(sample, flight), (std::vector<std::string>{"a.jpg", "b.jpg"}));
  EXPECT_EQ(StoredCount(sample, flight), 2);
  EXPECT_TRUE(FindCutOff(sample.service())->empty());
  // Another of its name that comes meanwhile is another's.
  LeaveArchive(sample, flight);
  EXPECT_EQ(test::ErrorOf(UnpackCutOff(sample.service(), left[0])).code, ErrorCode::kNotFound);
  ASSERT_TRUE(RemoveCutOff(sample.service(), left[0]));
  EXPECT_EQ(ListedNames(sample, flight), (std::vector<std::string>{"a.jpg", "a.zip", "b.jpg"}));
}

TEST(Unpack, WhatCameUnderANumberDoesNotComeAgain) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  for (const char* text : {"six", "one"}) {
    const std::string stored = StoreBytes(sample.service().store, flight, text);
    ASSERT_TRUE(sample.catalogue.AddFileUnderFreeName(flight, {"a.jpg", stored, 3}, storage::Now()));
  }
  LeaveArchive(sample, flight);
  sample.service().unpack = UnpackTwo;
  const auto left = test::ValueOf(FindCutOff(sample.service()));
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(test::ValueOf(UnpackCutOff(sample.service(), left[0])), 1u);
  EXPECT_EQ(ListedNames(sample, flight), (std::vector<std::string>{"a(2).jpg", "a.jpg", "a.zip", "b.jpg"}));
  EXPECT_EQ(StoredCount(sample, flight), 4);
}

TEST(Unpack, AnArchiveStaysWhileAJobReadsTheFlight) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  LeaveArchive(sample, flight);
  const auto left = test::ValueOf(FindCutOff(sample.service()));
  ASSERT_EQ(left.size(), 1u);
  ASSERT_TRUE(sample.queue.Add(flight, "{}", storage::Now()));
  ASSERT_TRUE(sample.queue.Claim("w", storage::Now())->has_value());
  EXPECT_EQ(RemoveCutOff(sample.service(), left[0]).error().code, ErrorCode::kConflict);
  EXPECT_EQ(ListedNames(sample, flight), std::vector<std::string>{"a.zip"});
}

TEST(Unpack, WhatCannotBeUnpackedAtTheStartStays) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  LeaveArchive(sample, flight);
  sample.service().unpack = [](const auto&, const auto&, const auto&, std::int64_t) {
    return Result<std::vector<storage::UnpackedFile>>(Error{ErrorCode::kOutOfSpace, "The disk is full.", ""});
  };
  const auto left = test::ValueOf(FindCutOff(sample.service()));
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(test::ErrorOf(UnpackCutOff(sample.service(), left[0])).code, ErrorCode::kOutOfSpace);
  EXPECT_EQ(ListedNames(sample, flight), std::vector<std::string>{"a.zip"});
  EXPECT_EQ(StoredCount(sample, flight), 1);
}

}  // namespace
}  // namespace skyquilt::api
