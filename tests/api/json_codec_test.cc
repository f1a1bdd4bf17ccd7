#include "api/json/json_codec.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "api/json/job_options.h"
#include "core/base/text/json_io.h"
#include "core/pipeline/mosaic_options.h"
#include "tests/support/value_of.h"

namespace skyquilt::api {

extern const std::string_view kOpenApi;  // api/openapi.json

namespace {

using nlohmann::json;

TEST(JobJson, EstimatesTheEndFromThePaceSoFar) {
  const storage::Time now = storage::Now();
  storage::Job job;
  job.state = storage::JobState::kRunning;
  job.progress = 0.25;
  job.attempt_started = now - std::chrono::seconds(10);
  EXPECT_NEAR(JobJson(job, now)["eta_s"].get<double>(), 30.0, 1e-6);
  job.progress = 0.0;
  EXPECT_TRUE(JobJson(job, now)["eta_s"].is_null());
  job.state = storage::JobState::kAccepted;
  EXPECT_EQ(JobJson(job, now)["state"], "accepted");
}

TEST(JobJson, ShowsAnErrorOnlyOnceTheJobHasFailed) {
  storage::Job job;
  job.error = storage::JobError{"io", "disk"};
  EXPECT_TRUE(JobJson(job, storage::Now())["error"].is_null());
  job.state = storage::JobState::kFailed;
  EXPECT_EQ(JobJson(job, storage::Now())["error"]["message"], "disk");
  EXPECT_TRUE(JobJson(job, storage::Now())["error"]["reason"].is_null());
  job.error->reason = R"({"code":"fail_not_stored","values":{}})";
  EXPECT_EQ(JobJson(job, storage::Now())["error"]["reason"]["code"], "fail_not_stored");
  job.error->reason = "of another version";
  EXPECT_TRUE(JobJson(job, storage::Now())["error"]["reason"].is_null());
}

TEST(FlightJson, NamesTheStateFromFilesJobAndMap) {
  const auto state = [](const FlightView& view) {
    return FlightJson(view, storage::Now())["state"].get<std::string>();
  };
  FlightView view;
  view.flight.options = "{}";
  EXPECT_EQ(state(view), "empty");
  view.flight.file_count = 1;
  EXPECT_EQ(state(view), "uploaded");
  view.job.emplace();
  EXPECT_EQ(state(view), "queued");
  view.job->state = storage::JobState::kRunning;
  EXPECT_EQ(state(view), "processing");
  view.job->state = storage::JobState::kDismissed;
  EXPECT_EQ(state(view), "uploaded");
  view.job->state = storage::JobState::kFailed;
  EXPECT_EQ(state(view), "failed");
  view.revision.emplace();
  EXPECT_EQ(state(view), "ready");
}

TEST(FlightJson, SaysWhenThePhotosWereTakenWhereThatIsKnown) {
  FlightView view;
  view.flight.options = "{}";
  const auto captured = [&] { return FlightJson(view, storage::Now())["captured"]; };
  EXPECT_TRUE(captured().is_null());
  view.revision.emplace();
  EXPECT_TRUE(captured().is_null());
  view.revision->first_capture = "2015-10-27T09:31:02-04:00";
  view.revision->last_capture = "2015-10-27T09:40:12-04:00";
  EXPECT_EQ(captured()["first"], "2015-10-27T09:31:02-04:00");
  EXPECT_EQ(captured()["last"], "2015-10-27T09:40:12-04:00");
}

TEST(FlightJson, SaysHowTrueTheMapIsWhereThatIsKnown) {
  FlightView view;
  view.flight.options = "{}";
  const auto quality = [&] { return FlightJson(view, storage::Now())["quality"]; };
  EXPECT_TRUE(quality().is_null());
  view.revision.emplace();
  for (const char* none : {"", "{", "7"}) {
    view.revision->quality = none;
    EXPECT_TRUE(quality().is_null()) << none;
  }
  view.revision->quality = R"({"status":"ready","absolute":{"sigma_m":2.3}})";
  EXPECT_EQ(quality()["absolute"]["sigma_m"], 2.3);
}

TEST(FlightJson, SaysWhetherTheMapHasAPlaceOnEarth) {
  FlightView view;
  view.flight.options = "{}";
  const auto georeferenced = [&] { return FlightJson(view, storage::Now())["georeferenced"]; };
  EXPECT_TRUE(georeferenced().is_null());
  view.revision.emplace();
  view.revision->bounds = {-0.001, -0.002, 0.001, 0.002};
  EXPECT_EQ(georeferenced(), false);
  for (const geo::LatLonBounds& bounds :
       {geo::LatLonBounds{7.4, 46.9, 7.5, 47.0}, {-0.01, 51.4, 0.01, 51.5}, {6.7, -0.01, 6.8, 0.01}}) {
    view.revision->bounds = bounds;
    EXPECT_EQ(georeferenced(), true) << bounds.west_deg;
  }
}

TEST(FlightJson, SurvivesNamesThatAreNotText) {
  FlightView view;
  view.flight.name = "\xff<img onerror=x>\x01";
  view.flight.options = "{}";
  EXPECT_TRUE(json::accept(JsonText(FlightJson(view, storage::Now()))));
}

TEST(ParseFlightFields, TakesWhatItKnows) {
  EXPECT_FALSE(ParseFlightFields("")->name);
  EXPECT_FALSE(ParseFlightFields("{}")->name);
  const auto fields = ParseFlightFields(
      R"({"name":"Field 3","options":{"gsd_m":0.1,"format":"webp","quality":90,"readout_ms":33}})");
  ASSERT_TRUE(fields);
  EXPECT_FALSE(fields->tags);
  EXPECT_FALSE(fields->is_kept);
  EXPECT_EQ(*fields->name, "Field 3");
  const auto options = test::ValueOf(ParseJobOptions(*fields->options));
  EXPECT_DOUBLE_EQ(*options.gsd_m, 0.1);
  EXPECT_FALSE(options.any_gsd);
  EXPECT_TRUE(ParseJobOptions(R"({"any_gsd":true})")->any_gsd);
  EXPECT_EQ(options.encoding, image::TileEncoding::kWebp);
  EXPECT_EQ(options.jpeg_quality, 90);
  EXPECT_DOUBLE_EQ(*options.readout_s, 0.033);
}

TEST(ParseJobOptions, TakesPlacesOfAMapForOneJob) {
  const auto options =
      test::ValueOf(ParseJobOptions(R"({"place":[{"shown":[0.001,-0.002],"is":[46.8,7.1]}]})"));
  ASSERT_EQ(options.placing->pairs.size(), 1U);
  EXPECT_DOUBLE_EQ(options.placing->pairs[0].shown.lon_deg, -0.002);
  EXPECT_DOUBLE_EQ(options.placing->pairs[0].is.lat_deg, 46.8);
  for (const char* bad :
       {R"({"place":[]})", R"({"place":{}})", R"({"place":[1]})", R"({"place":[{"shown":[1,2]}]})",
        R"({"place":[{"shown":[1,2],"is":[1]}]})", R"({"place":[{"shown":[1,2],"is":[86,2]}]})",
        R"({"place":[{"shown":[1,2],"is":[1,"2"]}]})", R"({"place":[{"shown":[1,2],"is":[1,2],"x":1}]})",
        R"({"place":[{"shown":[1e999,2],"is":[1,2]}]})"}) {
    EXPECT_FALSE(ParseJobOptions(bad)) << bad;
  }
}

TEST(ParseFlightFields, TakesTagsAndTheMarkToBeKept) {
  const auto fields = test::ValueOf(ParseFlightFields(R"({"tags":["north","maize","north"],"keep":true})"));
  EXPECT_EQ(*fields.tags, (std::vector<std::string>{"maize", "north"}));
  EXPECT_EQ(fields.is_kept, true);
  EXPECT_TRUE(ParseFlightFields(R"({"tags":[],"keep":false})")->tags->empty());
}

class BadBodies : public testing::TestWithParam<std::string> {};

TEST_P(BadBodies, AreRefused) {
  const auto fields = ParseFlightFields(GetParam());
  ASSERT_FALSE(fields) << GetParam().substr(0, 80);
  EXPECT_TRUE(fields.error().code == ErrorCode::kInvalidArgument ||
              fields.error().code == ErrorCode::kUnprocessable ||
              fields.error().code == ErrorCode::kTooLarge);
}

INSTANTIATE_TEST_SUITE_P(
    ParseFlightFields, BadBodies,
    testing::Values("{", "[]", "1", "\"x\"", R"({"nme":"x"})", R"({"name":1})", R"({"name":""})",
                    R"({"tags":"maize"})", R"({"tags":[1]})", R"({"tags":[""]})", R"({"tags":["a,b"]})",
                    R"({"tags":["a\nb"]})", R"({"tags":{"a":"b"}})", R"({"tags":null})", R"({"keep":1})",
                    R"({"keep":null})", "{\"name\":\"" + std::string(300, 'a') + "\"}", R"({"options":1})",
                    R"({"options":{"gsd":1}})", R"({"options":{"gsd_m":0}})", R"({"options":{"gsd_m":-1}})",
                    R"({"options":{"gsd_m":1e400}})", R"({"options":{"gsd_m":"1"}})",
                    R"({"options":{"any_gsd":1}})", R"({"options":{"max_look_deg":80}})",
                    R"({"options":{"max_look_deg":null}})", R"({"options":{"readout_ms":-1}})",
                    R"({"options":{"readout_ms":501}})", R"({"options":{"readout_ms":"33"}})",
                    R"({"options":{"place":[{"shown":[1,2],"is":[1,2]}]}})", R"({"options":{"quality":0}})",
                    R"({"options":{"quality":85.5}})", R"({"options":{"quality":9999999999999999999999}})",
                    R"({"options":{"format":"gif"}})", R"({"options":{"method":"magic"}})",
                    R"({"options":{"surface":"rough"}})", R"({"options":{"surface":true}})",
                    R"({"options":{"heights":"all"}})", R"({"options":{"heights":true}})",
                    "{\"name\":\"\xff\"}", std::string(100000, '['),
                    std::string(40, '[') + std::string(40, ']'), std::string(70000, ' ') + "{}x"));

TEST(FormatTime, IsRfc3339InUtc) {
  EXPECT_EQ(FormatTime(storage::FromUs(0)), "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(FormatTime(storage::FromUs(1795233303123456)), "2026-11-21T03:55:03.123Z");
}

TEST(ParseJobOptions, TakesABoundaryAndATakeoffHeight) {
  const auto options = ParseJobOptions(
      R"({"boundary":{"type":"Polygon","coordinates":[[[7,46],[8,46],[8,47],[7,46]]]},"takeoff_height_m":512.5})");
  ASSERT_TRUE(options) << options.error().message;
  ASSERT_TRUE(options->boundary);
  EXPECT_EQ(options->boundary->Bounds(), (geo::LatLonBounds{7.0, 46.0, 8.0, 47.0}));
  EXPECT_EQ(options->takeoff_height_amsl_m, 512.5);
  EXPECT_FALSE(ParseJobOptions(R"({"boundary":null,"takeoff_height_m":null})")->boundary);
  for (const char* bad :
       {R"({"boundary":"7,46"})", R"({"boundary":{}})",
        R"({"boundary":{"type":"Point","coordinates":[7,46]}})",
        R"({"boundary":{"type":"Polygon","coordinates":[[[7,46],[8,46],[7,46]]]}})",
        R"({"takeoff_height_m":"512"})", R"({"takeoff_height_m":-501})", R"({"takeoff_height_m":9001})"}) {
    EXPECT_FALSE(ParseJobOptions(bad)) << bad;
  }
}

// As the contract has a row of the table.
json SchemaOf(const pipeline::JobOption& option) {
  using pipeline::JobOptionKind;
  json schema = {{"description", option.help}};
  const std::optional<double> usual = option.get(pipeline::MosaicOptions());
  if (option.kind == JobOptionKind::kChoice) {
    schema["enum"] = std::vector<std::string>(option.choices.begin(), option.choices.end());
    schema["default"] = option.choices[static_cast<std::size_t>(*usual)];
    return schema;
  }
  if (option.kind == JobOptionKind::kYesNo) {
    schema["type"] = "boolean";
    schema["default"] = *usual != 0.0;
    return schema;
  }
  const char* type = option.kind == JobOptionKind::kWhole ? "integer" : "number";
  schema["type"] = option.may_be_open ? json{type, "null"} : json(type);
  schema["minimum"] = option.least;
  schema["maximum"] = option.most;
  if (usual) schema["default"] = *usual;
  return schema;
}

TEST(JobOptionTable, IsWhatTheContractSays) {
  json contract = json::parse(kOpenApi)["components"]["schemas"]["JobOptions"]["properties"];
  for (const pipeline::JobOption& option : pipeline::JobOptionTable()) {
    ASSERT_TRUE(contract.contains(option.name)) << option.name;
    if (option.kind != pipeline::JobOptionKind::kOther) {
      EXPECT_EQ(contract[option.name], SchemaOf(option)) << option.name << ": " << SchemaOf(option).dump();
    }
    contract.erase(option.name);
  }
  EXPECT_TRUE(contract.empty()) << contract.dump();
}

TEST(JobOptionTable, SaysWhatAValueMustBe) {
  const auto refused = [](const char* options) { return ParseJobOptions(options).error().message; };
  EXPECT_NE(refused(R"({"max_look_deg":80})").find("between 10 and 75 degrees off the vertical"),
            std::string::npos);
  EXPECT_NE(refused(R"({"quality":8.5})").find("a whole number between 1 and 100"), std::string::npos);
  EXPECT_NE(refused(R"({"surface":"flat"})").find("\"smooth\", \"dense\" or \"auto\""), std::string::npos);
  EXPECT_NE(refused(R"({"any_gsd":1})").find("true or false"), std::string::npos);
  EXPECT_NE(refused(R"({"colour":1})").find("place, layers and import_file"), std::string::npos);
  EXPECT_FALSE(ParseJobOptions(R"({"quality":null})"));
  EXPECT_EQ(ParseJobOptions(R"({"readout_ms":null,"heights":"dtm"})")->heights,
            pipeline::MapHeights::kGround);
}

}  // namespace
}  // namespace skyquilt::api
