// libFuzzer: any JSON taken for the report of a stage. Checked: it is refused, or written and read again as
// the same.
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/check.h"
#include "core/pipeline/report/report_codec.h"

namespace {

using Json = nlohmann::ordered_json;

template <typename Report>
void ReadAndWrite(const Json& json) {
  const auto text_of = [](const Report& report) {
    return skyquilt::pipeline::JsonOf<Json>(report).dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  std::string text;
  try {
    text = text_of(skyquilt::pipeline::ReportOf<Report>(json));
  } catch (const Json::exception&) {
    return;  // refused
  }
  const std::string again = text_of(skyquilt::pipeline::ReportOf<Report>(Json::parse(text)));
  SKYQUILT_CHECK(again == text, "a report that is read as another");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Json json = Json::parse(data, data + size, nullptr, false);
  if (json.is_discarded()) return 0;
  ReadAndWrite<skyquilt::poses::PoseReport>(json);
  ReadAndWrite<skyquilt::ground::ModelGroundReport>(json);
  ReadAndWrite<skyquilt::alignment::AlignReport>(json);
  return 0;
}
