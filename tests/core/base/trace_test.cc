#include "core/base/trace.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>
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

TEST(Trace, CollectsNothingBeforeItBeginsAndAfterItEnds) {
  { const TraceSpan early("early"); }
  BeginTrace();
  EndTrace();
  { const TraceSpan late("late"); }
  BeginTrace();
  EXPECT_TRUE(nlohmann::json::parse(EndTrace())["traceEvents"].empty());
}

}  // namespace
}  // namespace skyquilt
