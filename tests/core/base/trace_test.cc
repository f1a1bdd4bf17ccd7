#include "core/base/trace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

namespace skyquilt {
namespace {

TEST(Trace, WritesSpansOfAllThreadsInChromesFormat) {
  BeginTrace();
  {
    const TraceSpan outer("render");
    const TraceSpan inner("decode", "DJI \"1\"\n\xC3\xA4.JPG");
    std::thread([] { const TraceSpan other("encode"); }).join();
  }
  const auto trace = nlohmann::json::parse(EndTrace());
  const auto& events = trace["traceEvents"];
  ASSERT_EQ(events.size(), 3U);  // in the order in which they ended
  EXPECT_EQ(events[0]["name"], "encode");
  EXPECT_EQ(events[1]["name"], "decode");
  EXPECT_EQ(events[2]["name"], "render");
  EXPECT_NE(events[0]["tid"], events[1]["tid"]);
  EXPECT_EQ(events[1]["tid"], events[2]["tid"]);
  for (const auto& event : events) EXPECT_EQ(event["ph"], "X");
  EXPECT_LE(events[2]["ts"], events[1]["ts"]);
  EXPECT_GE(events[2]["ts"].get<std::int64_t>() + events[2]["dur"].get<std::int64_t>(),
            events[1]["ts"].get<std::int64_t>() + events[1]["dur"].get<std::int64_t>());
  EXPECT_EQ(events[1]["args"]["item"].get<std::string>().substr(0, 9), "DJI \"1\"\n\xC3");
}

TEST(Trace, WritesADecisionWithItsNumbersOnALineOfItsOwn) {
  BeginTrace();
  TraceDecision("photo placed", {{"residual_px", 0.25}, {"error_m", std::nan("")}}, "a.jpg");
  TraceDecision("nothing said", {});
  const std::string text = EndTrace();
  const auto events = nlohmann::json::parse(text)["traceEvents"];
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0]["ph"], "i");
  EXPECT_EQ(events[0]["args"],
            nlohmann::json::parse(R"({"item":"a.jpg","residual_px":0.25,"error_m":null})"));
  EXPECT_FALSE(events[1].contains("args"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);  // the head, one each, the end
}

TEST(Trace, CollectsNothingBeforeItBeginsAndAfterItEnds) {
  { const TraceSpan early("early"); }
  TraceDecision("early", {{"photos", 1}});
  BeginTrace();
  EndTrace();
  { const TraceSpan late("late"); }
  BeginTrace();
  EXPECT_TRUE(nlohmann::json::parse(EndTrace())["traceEvents"].empty());
}

}  // namespace
}  // namespace skyquilt
