// Archives that become their files, also where a server died meanwhile.
#include "api/uploads/unpack.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

TEST(Unpack, WhatADeadServerLeftIsUnpackedAtTheStart) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string at = "/api/v1/flights/" + flight + "/files/a.jpg";
  ASSERT_EQ(sample.Send(Method::kPut, at, "one").status, 201);  // came in before
  LeaveArchive(sample, flight);
  sample.service().unpack = UnpackTwo;
  std::vector<std::string> told;
  ASSERT_TRUE(UnpackCutOff(sample.service(), [&](const std::string& line) { told.push_back(line); }));
  EXPECT_EQ(ListedNames(sample, flight), (std::vector<std::string>{"a.jpg", "b.jpg"}));
  EXPECT_EQ(StoredCount(sample, flight), 2);
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].find("1 file came in"), std::string::npos) << told[0];
  ASSERT_TRUE(UnpackCutOff(sample.service(), [&](const std::string& line) { told.push_back(line); }));
  EXPECT_EQ(told.size(), 1u) << "there is nothing more";
}

TEST(Unpack, WhatCannotBeUnpackedAtTheStartStays) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  LeaveArchive(sample, flight);
  sample.service().unpack = [](const auto&, const auto&, const auto&, std::int64_t) {
    return Result<std::vector<storage::UnpackedFile>>(Error{ErrorCode::kOutOfSpace, "The disk is full.", ""});
  };
  std::string told;
  ASSERT_TRUE(UnpackCutOff(sample.service(), [&](const std::string& line) { told += line; }));
  EXPECT_NE(told.find("stays: The disk is full."), std::string::npos) << told;
  EXPECT_EQ(ListedNames(sample, flight), std::vector<std::string>{"a.zip"});
  EXPECT_EQ(StoredCount(sample, flight), 1);
}

}  // namespace
}  // namespace skyquilt::api
