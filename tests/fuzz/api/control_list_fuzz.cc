// What somebody sends as control points, and the list that is written of it, as the stitcher reads it.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "api/control/control_list.h"
#include "core/base/check.h"
#include "core/flight/logs/texts/gcp_list.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt;
  const auto text = api::ControlListText({reinterpret_cast<const char*>(bytes), size});
  if (!text) {
    SKYQUILT_CHECK(!text.error().message.empty(), "a refusal without a word");
    return 0;
  }
  if (text->empty()) return 0;
  const auto list = flight::ParseGcpList("gcp_list.txt", flight::BytesOf(*text));
  if (!list) return 0;  // an unknown reference system
  SKYQUILT_CHECK(list->points.size() <= api::kMaxControlPoints, "more points than are taken");
  SKYQUILT_CHECK(list->sightings.size() <= api::kMaxControlMarks, "more marks than are taken");
  for (const flight::GcpPoint& point : list->points)
    SKYQUILT_CHECK(!point.name.empty(), "a point has lost its name");
  return 0;
}
