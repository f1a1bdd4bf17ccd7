// What options mean that clients of the NodeODM-compatible node send.
#include "api/nodeodm/node_options.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "api/json/job_options.h"
#include "core/pipeline/mosaic_options.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

NodeChoice Chosen(const std::string& options) {
  const Result<NodeChoice> choice = ParseNodeOptions(options);
  EXPECT_TRUE(choice) << options;
  return choice ? *choice : NodeChoice();
}

TEST(NodeOptions, OfferTheUsualNamesAndSayWhatDoesNothing) {
  std::set<std::string> names;
  for (const json& option : json::parse(NodeOptionsJson())) {
    EXPECT_EQ(option.size(), 5u) << option;  // clients unpack exactly these
    EXPECT_TRUE(option["value"].is_string()) << option;
    EXPECT_EQ(option["domain"].is_array(), option["type"] == "enum") << option;
    EXPECT_FALSE(option["help"].get<std::string>().empty()) << option;
    EXPECT_TRUE(names.insert(option["name"]).second) << option;
  }
  std::istringstream usual(
      "dsm dtm fast-orthophoto mesh-size feature-quality pc-quality orthophoto-resolution auto-boundary"
      " skip-3dmodel orthophoto-png cog build-overviews max-concurrency split gps-accuracy ignore-gsd crop"
      " dem-resolution min-num-features camera-lens");
  for (std::string name; usual >> name;) EXPECT_TRUE(names.contains(name)) << name;
}

TEST(NodeOptions, ThoseWithoutEffectAreTakenAndShownInTheirTypes) {
  const NodeChoice choice = Chosen(R"([{"name":"gltf","value":true},{"name":"fast-orthophoto","value":"true"},
    {"name":"mesh-size","value":"300000"},{"name":"gps-accuracy","value":2.5},{"name":"pc-quality","value":"high"}])");
  EXPECT_EQ(choice.job_options, "{}");
  EXPECT_EQ(json::parse(choice.shown), json::parse(R"([{"name":"gltf","value":true},
    {"name":"fast-orthophoto","value":true},{"name":"mesh-size","value":300000},
    {"name":"gps-accuracy","value":2.5},{"name":"pc-quality","value":"high"}])"));
  EXPECT_TRUE(choice.unknown.empty());
}

TEST(NodeOptions, ResolutionIsNeverFinerThanThePhotos) {
  const NodeChoice choice = Chosen(R"([{"name":"orthophoto-resolution","value":"0.01"}])");
  const auto options = ParseJobOptions(choice.job_options);
  ASSERT_TRUE(options);
  EXPECT_DOUBLE_EQ(*options->gsd_m, 0.001);
  EXPECT_TRUE(options->not_finer_than_photos);
  EXPECT_TRUE(options->any_gsd);  // its unit is said
  EXPECT_EQ(Chosen(R"([{"name":"orthophoto-resolution","value":0}])").job_options, "{}");
  EXPECT_EQ(json::parse(Chosen(R"([{"name":"orthophoto-resolution","value":5}])").job_options)["gsd_m"],
            0.05);
}

TEST(NodeOptions, UnknownNamesAreNoErrorButTold) {
  const NodeChoice choice =
      Chosen(R"([{"name":"warp-speed","value":9},{"name":"orthophoto-quality","value":70}])");
  EXPECT_EQ(choice.unknown, std::vector<std::string>{"warp-speed"});
  EXPECT_EQ(choice.shown, R"([{"name":"orthophoto-quality","value":70}])");
}

TEST(NodeOptions, HeightsAreOfTheSurfaceOrOfTheGroundAsWell) {
  const auto heights_of = [](const char* options) {
    return json::parse(Chosen(options).job_options).value("heights", "");
  };
  EXPECT_EQ(heights_of(R"([{"name":"dsm","value":"true"}])"), "dsm");
  EXPECT_EQ(heights_of(R"([{"name":"dtm","value":true}])"), "dtm");
  EXPECT_EQ(heights_of(R"([{"name":"dtm","value":true},{"name":"dsm","value":true}])"), "dtm");
  EXPECT_EQ(heights_of(R"([{"name":"dsm","value":true},{"name":"dtm","value":true}])"), "dtm");
  EXPECT_EQ(heights_of(R"([{"name":"dtm","value":true},{"name":"dsm","value":false}])"), "dtm");
  EXPECT_EQ(heights_of(R"([{"name":"dsm","value":false},{"name":"dtm","value":"false"}])"), "");
}

TEST(NodeOptions, BadValuesAreNamed) {
  for (const char* bad :
       {R"([{"name":"dsm","value":"perhaps"}])", R"([{"name":"mesh-size","value":"many"}])",
        R"([{"name":"mesh-size","value":1.5}])", R"([{"name":"pc-quality","value":[]}])",
        R"([{"name":"orthophoto-resolution","value":-1}])", R"([{"name":"tile-format","value":"bmp"}])"}) {
    const Result<NodeChoice> choice = ParseNodeOptions(bad);
    ASSERT_FALSE(choice) << bad;
    EXPECT_EQ(json::parse(choice.error().message)[0]["name"], json::parse(bad)[0]["name"]);
  }
}

TEST(NodeOptions, ABoundaryReachesTheJobAsTextOrAsAnObject) {
  const std::string area = R"({"type":"Polygon","coordinates":[[[7,46],[8,46],[8,47],[7,46]]]})";
  for (const std::string& value : {json(area).dump(), area}) {
    const NodeChoice choice = Chosen(R"([{"name":"boundary","value":)" + value + "}]");
    const auto options = ParseJobOptions(choice.job_options);
    ASSERT_TRUE(options) << choice.job_options;
    EXPECT_TRUE(options->boundary);
  }
  EXPECT_EQ(Chosen(R"([{"name":"boundary","value":""}])").job_options, "{}");
  for (const char* bad : {"\"7,46\"", "\"[]\"", "[1]", R"({"type":"Point","coordinates":[7,46]})"}) {
    EXPECT_FALSE(ParseNodeOptions(R"([{"name":"boundary","value":)" + std::string(bad) + "}]")) << bad;
  }
}

TEST(NodeOptionList, OffersWhatTheTableOfJobOptionsHas) {
  int held = 0;
  for (const NodeOption& option : NodeOptionList()) {
    if (std::string_view(option.type) != "enum" || option.effect != NodeOptionEffect::kJob) continue;
    const pipeline::JobOption* row = pipeline::FindJobOption(option.job_option);
    ASSERT_NE(row, nullptr) << option.name;
    const std::vector<std::string> words(row->choices.begin(), row->choices.end());
    EXPECT_EQ(nlohmann::json::parse(option.domain), nlohmann::json(words)) << option.name;
    const auto usual = static_cast<std::size_t>(*row->get(pipeline::MosaicOptions()));
    EXPECT_EQ(option.value, words.at(usual)) << option.name;
    ++held;
  }
  EXPECT_EQ(held, 3);
}

}  // namespace
}  // namespace skyquilt::api
