// What sandboxed processes say, believed only so far.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/base/text/json_io.h"
#include "core/flight/remarks/because.h"
#include "core/pipeline/report/map_quality.h"
#include "server/jobs/child_messages.h"
#include "server/jobs/job_limits.h"
#include "server/sandbox/sandboxed_child.h"
#include "tests/support/value_of.h"

namespace skyquilt::server {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

class MessagePipe : public testing::Test {
 protected:
  MessagePipe() {
    if (pipe2(ends_, O_CLOEXEC) != 0) std::abort();
  }
  ~MessagePipe() override {
    close(ends_[0]);
    Hush();
  }
  void Hush() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }
  void WriteRaw(std::string_view bytes) {
    ASSERT_EQ(write(ends_[1], bytes.data(), bytes.size()), std::ssize(bytes));
  }
  int ends_[2];
};

TEST_F(MessagePipe, MessagesComeAsTheyWereSent) {
  MessageWriter writer(ends_[1]);
  MessageReader reader(ends_[0], 1000);
  EXPECT_TRUE(writer.Write("one"));
  EXPECT_TRUE(writer.Write(""));
  EXPECT_TRUE(writer.Write(std::string(1000, 'x')));
  EXPECT_EQ(reader.Read(milliseconds(1000)), "one");
  EXPECT_EQ(reader.Read(milliseconds(1000)), "");
  EXPECT_EQ(reader.Read(milliseconds(1000)), std::string(1000, 'x'));
  EXPECT_EQ(reader.Read(milliseconds(10)), std::nullopt);
  EXPECT_FALSE(reader.is_ended());
  Hush();
  EXPECT_EQ(reader.Read(milliseconds(1000)), std::nullopt);
  EXPECT_TRUE(reader.is_ended());
}

TEST_F(MessagePipe, LargerThanThePipe) {
  const std::string large(3 << 20, 'y');
  MessageReader reader(ends_[0], large.size());
  std::thread writing([&] { EXPECT_TRUE(MessageWriter(ends_[1]).Write(large)); });
  EXPECT_EQ(reader.Read(milliseconds(20'000)), large);
  writing.join();
}

TEST_F(MessagePipe, TooLongOrCutOffIsTheEnd) {
  MessageReader reader(ends_[0], 1000);
  WriteRaw(std::string("\xe9\x03\0\0", 4));  // 1001 bytes to come
  EXPECT_EQ(reader.Read(milliseconds(1000)), std::nullopt);
  EXPECT_TRUE(reader.is_ended());
}

TEST_F(MessagePipe, AHalfMessageIsNone) {
  MessageReader reader(ends_[0], 1000);
  WriteRaw(std::string("\x05\0\0\0abc", 7));
  Hush();
  EXPECT_EQ(reader.Read(milliseconds(1000)), std::nullopt);
  EXPECT_TRUE(reader.is_ended());
}

TEST_F(MessagePipe, WhoDoesNotReadHoldsNobodyUp) {
  fcntl(ends_[1], F_SETFL, O_NONBLOCK);
  EXPECT_FALSE(MessageWriter(ends_[1]).Write(std::string(1 << 20, 'z'), milliseconds(50)));
}

TEST_F(MessagePipe, WhoAlwaysHasMoreToSayKeepsNobodyListening) {
  const std::string message(40 << 10, 'a');  // comes in more than one piece
  MessageReader reader(ends_[0], message.size());
  ASSERT_TRUE(MessageWriter(ends_[1]).Write(message));
  EXPECT_EQ(reader.Read(milliseconds(0)), std::nullopt);
  EXPECT_FALSE(reader.is_ended());
  EXPECT_EQ(reader.Read(milliseconds(20'000)), message);
}

StitchOutcome Outcome() {
  StitchOutcome outcome;
  outcome.figures.bounds = {10.0, 50.0, 10.1, 50.1};
  outcome.figures.min_zoom = 12;
  outcome.figures.max_zoom = 21;
  outcome.figures.gsd_m = 0.03;
  outcome.figures.photos_total = 7;
  outcome.figures.photos_aligned = 6;
  outcome.figures.photos_left_out = 1;
  outcome.figures.first_capture = "2015-10-27T09:31:02-04:00";
  outcome.figures.quality = pipeline::QualityJson({});
  outcome.stages_s = {{"read", 0.5}, {"align", 2.0}};
  return outcome;
}

TEST(JobMessages, ComeAsTheyWereSent) {
  const StitchTask task{.files = {{"DJI \xff.jpg", "/d/f/1"}},
                        .files_dir = "/d/f",
                        .previous_dir = "",
                        .out_dir = "/d/w",
                        .options = "{\"quality\":80}",
                        .title = "Field",
                        .units_dir = "/d/u",
                        .unit = UnitToDo{UnitKind::kRender, 2, 7, 900, 0},
                        .renders = 7,
                        .memory_bytes = 5,
                        .cpu_s = 6};
  const auto told = test::ValueOf(ParseTask(ToText(task)));
  EXPECT_EQ(told.files[0].path, "/d/f/1");
  EXPECT_EQ(told.options, task.options);
  EXPECT_EQ(told.memory_bytes, 5);
  EXPECT_EQ(told.units_dir, "/d/u");
  EXPECT_EQ(told.renders, 7);
  ASSERT_TRUE(told.unit);
  EXPECT_EQ(told.unit->kind, UnitKind::kRender);
  EXPECT_EQ(told.unit->number, 2);
  EXPECT_EQ(told.unit->count, 7);
  EXPECT_EQ(told.unit->blocks, 900);
  const auto outcome = test::ValueOf(ParseJobMessage(ToText(JobMessage(Outcome()))));
  const auto& made = std::get<StitchOutcome>(outcome);
  EXPECT_EQ(made.figures.bounds, Outcome().figures.bounds);
  EXPECT_EQ(made.figures.photos_aligned, 6);
  EXPECT_EQ(made.figures.first_capture, "2015-10-27T09:31:02-04:00");
  EXPECT_EQ(made.figures.last_capture, "");
  EXPECT_EQ(made.figures.quality, Outcome().figures.quality);
  EXPECT_EQ(made.stages_s, Outcome().stages_s);
  const auto error = ParseJobMessage(ToText(JobMessage(Error{ErrorCode::kOutOfSpace, "full", "disk"})));
  EXPECT_EQ(std::get<Error>(*error).code, ErrorCode::kOutOfSpace);
  EXPECT_EQ(std::get<Error>(*error).reason, nullptr);
  const flight::Remark left{
      flight::RemarkCode::kPhotoDoes,
      {{"photo", "a.jpg"}, {"said", flight::Remark(flight::RemarkCode::kDoubtBlurred)}}};
  const Error because = flight::Because(ErrorCode::kUnprocessable,
                                        {flight::RemarkCode::kFailNoneDrawable, {{"left", left}}}, "all");
  const auto with_reason = test::ValueOf(ParseJobMessage(ToText(JobMessage(because))));
  EXPECT_EQ(*std::get<Error>(with_reason).reason, *because.reason);
  EXPECT_EQ(std::get<Error>(with_reason).message, because.message);
  const Error wordy = flight::Because(ErrorCode::kConflict, flight::Remark(std::string(1 << 16, 'a')));
  EXPECT_EQ(std::get<Error>(*ParseJobMessage(ToText(JobMessage(wordy)))).reason, nullptr);
  const auto progress =
      ParseJobMessage(ToText(JobMessage(StageProgress{std::nan(""), std::string(400, '\xff')})));
  ASSERT_TRUE(progress) << "a name that is no UTF-8 costs no job";
  EXPECT_EQ(std::get<StageProgress>(*progress).fraction, 0.0);
}

TEST(JobMessages, FiguresThatNoMapHasAreRefused) {
  const Json good = Json::parse(ToText(JobMessage(Outcome())));
  ASSERT_TRUE(ParseJobMessage(good.dump()));
  Json across = good;
  across["done"]["bounds"] = {179.9, -17.1, 180.1, -17.0};
  EXPECT_TRUE(ParseJobMessage(across.dump())) << "a map across the antimeridian is one";
  const std::pair<const char*, Json> wrong[] = {{"/done/bounds/0", -181.0},
                                                {"/done/bounds/2", 371.0},
                                                {"/done/bounds/3", 91.0},
                                                {"/done/bounds/2", 9.0},
                                                {"/done/bounds/1", nullptr},
                                                {"/done/min_zoom", -1},
                                                {"/done/max_zoom", 31},
                                                {"/done/max_zoom", 1e300},
                                                {"/done/gsd_m", -1.0},
                                                {"/done/photos_total", 1e18},
                                                {"/done/photos_aligned", "6"},
                                                {"/done/photos_left_out", -1},
                                                {"/done/first_capture", "2015<img onerror=x>"},
                                                {"/done/last_capture", std::string(26, '1')},
                                                {"/done/last_capture", nullptr},
                                                {"/done/quality", "{\"status\":\"<b>\"}"},
                                                {"/done/quality", std::string(3000, ' ')},
                                                {"/done/quality", 7},
                                                {"/done/stages_s/0/0", "read\n"},
                                                {"/done/stages_s/0/1", -1.0},
                                                {"/done/stages_s", Json::array({1})},
                                                {"/done", nullptr}};
  for (const auto& [where, value] : wrong) {
    Json json = good;
    json[Json::json_pointer(where)] = value;
    EXPECT_FALSE(ParseJobMessage(json.dump())) << where << " " << value;
  }
  Json many = good;
  for (int i = 0; i < 100; ++i) many["done"]["stages_s"].push_back({"read", 1.0});
  EXPECT_FALSE(ParseJobMessage(many.dump()));
  for (const char* text :
       {"", "{", "[]", "3", "{}", R"({"stage":"<script>"})", R"({"stage":""})", R"({"stage":7})",
        R"({"fraction":1.5,"message":""})", R"({"fraction":0.5})", "{\"fraction\":0.5,\"message\":\"\xff\"}",
        R"({"error":{"code":99,"message":"","detail":""}})",
        R"({"error":{"code":1e300,"message":"","detail":""}})", R"({"error":"x"})",
        R"({"error":{"code":1,"message":"","detail":"","reason":{"code":"of_tomorrow","values":{}}}})",
        R"({"error":{"code":1,"message":"","detail":"","reason":{"code":"fail_quota"}}})",
        R"({"error":{"code":1,"message":"","detail":"","reason":null}})"}) {
    EXPECT_FALSE(ParseJobMessage(text)) << text;
  }
  Json deep = {{"code", "no_ties"}, {"values", Json::object()}};
  for (int i = 0; i < 20; ++i) deep = {{"code", "then"}, {"values", {{"said", Json::array({deep})}}}};
  const Json too_deep = {{"code", 1}, {"message", ""}, {"detail", ""}, {"reason", deep}};
  EXPECT_FALSE(ParseJobMessage(Json({{"error", too_deep}}).dump()));
  EXPECT_FALSE(ParseJobMessage(Json({{"stage", std::string(33, 'a')}}).dump()));
  EXPECT_FALSE(ParseJobMessage(Json({{"fraction", 0.5}, {"message", std::string(2000, 'a')}}).dump()));
}

TEST(ErrorMessages, OneWithoutEndWithinItselfIsNoneAndHarmsNobody) {
  constexpr std::size_t kDeep = 500'000;
  const std::string arrays = std::string(kDeep, '[') + std::string(kDeep, ']');
  const std::string head = R"({"code":1,"message":"","detail":"","reason":)";
  EXPECT_FALSE(ErrorOfJson(ParseJson(head + arrays + "}")));
  EXPECT_FALSE(ErrorOfJson(ParseJson(head + R"({"code":"no_ties","values":{"a":)" + arrays + "}}}")));
}

TEST(PreviewMessages, ComeAsTheyWereSentAndNothingElse) {
  const std::string id = "01hzzzzzzzzzzzzzzzzzzzzzzz";
  storage::Preview preview;
  preview.photos = 3;
  preview.min_zoom = 10;
  preview.max_zoom = 18;
  preview.bounds = {10.0, 50.0, 10.1, 50.1};
  preview.changed = preview.bounds;
  const PreviewRequest request{{{"a.jpg", id, 0}}, {}, preview};
  const auto asked = test::ValueOf(ParseRequest(ToText(request)));
  EXPECT_EQ(asked.fresh[0].stored_name, id);
  EXPECT_EQ(asked.preview->bounds, preview.bounds);
  const auto drawn = ParsePreviewMessage(ToText(PreviewMessage(PreviewDrawn{preview, {id}})));
  ASSERT_TRUE(drawn) << drawn.error().detail;
  EXPECT_EQ(std::get<PreviewDrawn>(*drawn).preview->photos, 3);
  const auto begun = test::ValueOf(ParsePreviewMessage(ToText(PreviewMessage(PhotoBegun{id}))));
  EXPECT_EQ(std::get<PhotoBegun>(begun).stored_name, id);
  const Json good = Json::parse(ToText(PreviewMessage(PreviewDrawn{preview, {}})));
  const std::pair<const char*, Json> wrong[] = {
      {"/preview/photos", 0},       {"/preview/photos", 1e300},    {"/preview/max_zoom", 99},
      {"/preview/bounds/0", 999.0}, {"/preview/changed/1", -91.0}, {"/forgone", {"../../catalogue.db"}}};
  for (const auto& [where, value] : wrong) {
    Json json = good;
    json[Json::json_pointer(where)] = value;
    EXPECT_FALSE(ParsePreviewMessage(json.dump())) << where << " " << value;
  }
  EXPECT_FALSE(ParsePreviewMessage(R"({"photo":"../x"})"));
}

TEST(JobLimits, GrowWithWhatWasUploaded) {
  const pipeline::MosaicOptions options;
  const JobLimits one = LimitsOfJob(1, 20 << 20, options, {});
  EXPECT_EQ(one.wall, std::chrono::seconds(600 + 60 + 20));
  EXPECT_EQ(one.cpu_s, 2 * one.wall.count());
  EXPECT_EQ(one.memory_bytes, options.max_memory_bytes + (std::int64_t{4} << 30) + (2 << 20));
  const JobLimits many = LimitsOfJob(2000, std::int64_t{20} << 30, options, {});
  EXPECT_GT(many.wall, std::chrono::hours(30));
  EXPECT_EQ(LimitsOfJob(1, 0, options, {.machine_memory_bytes = std::int64_t{4} << 30}).memory_bytes,
            std::int64_t{3} << 30);
  EXPECT_GT(MemoryOfThisMachine(), 256 << 20);
  const JobLimits given = LimitsOfJob(2000, 0, options, {std::chrono::seconds(7), 1 << 20});
  EXPECT_EQ(given.wall, std::chrono::seconds(7));
  EXPECT_EQ(given.memory_bytes, 1 << 20);
}

TEST(JobLimits, CountAFilmAsTheFramesThatMayBecomePhotos) {
  constexpr std::int64_t kMib = 1 << 20;
  EXPECT_EQ(MostPhotosIn("DJI_0001.JPG", 20 * kMib), 1);
  EXPECT_EQ(MostPhotosIn("flight.gpx", 20 * kMib), 1);
  EXPECT_EQ(MostPhotosIn("DJI_0001.MP4", 1), 1);
  EXPECT_EQ(MostPhotosIn("DJI_0001.MP4", 100 * kMib), 400);
  EXPECT_EQ(MostPhotosIn("film.mov", 4000 * kMib), 3000) << "no more are taken";
}

}  // namespace
}  // namespace skyquilt::server
