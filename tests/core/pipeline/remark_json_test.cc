// What a report remarks is read again as it was; nothing damaged is taken for a remark.
#include "core/flight/remarks/remark_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace skyquilt::pipeline {
namespace {

using flight::Remark;
using flight::RemarkCode;
using Document = nlohmann::ordered_json;

TEST(RemarkJson, IsReadAgainAsItWas) {
  const std::vector<Remark> remarks{
      "as a reader has it",
      RemarkCode::kNoTies,
      {RemarkCode::kGroups, {{"groups", 3}}},
      {RemarkCode::kPlacedByControl, {{"points", 5}, {"apart_m", 2.0}, {"turn_deg", -0.25}, {"times", 1.0}}},
      {RemarkCode::kOfPhoto, {{"photo", "a.jpg"}, {"said", Remark(RemarkCode::kDoubtBlurred)}}}};
  const Document json = flight::JsonOfRemarks<Document>(remarks);
  EXPECT_EQ(json[0].dump(), R"({"code":"text","values":{"text_words":"as a reader has it"}})");
  EXPECT_EQ(
      json[4].dump(),
      R"({"code":"of_photo","values":{"photo":"a.jpg","said":[{"code":"doubt_blurred","values":{}}]}})");
  EXPECT_EQ(flight::RemarksOfJson(Document::parse(json.dump())), remarks);
  const auto cbor = nlohmann::json::to_cbor(flight::JsonOfRemarks<nlohmann::json>(remarks));
  EXPECT_EQ(flight::RemarksOfJson(nlohmann::json::from_cbor(cbor)), remarks);
}

TEST(RemarkJson, OfAnotherKindIsRefused) {
  for (const char* damaged :
       {R"({})", R"({"code":"no_ties"})", R"({"code":"no_such_code","values":{}})",
        R"({"code":7,"values":{}})", R"({"code":"no_ties","values":"none"})",
        R"({"code":"groups","values":{"groups":null}})", R"({"code":"of_photo","values":{"said":[7]}})"}) {
    EXPECT_THROW(flight::RemarkOfJson(Document::parse(damaged)), Document::exception) << damaged;
  }
}

}  // namespace
}  // namespace skyquilt::pipeline
