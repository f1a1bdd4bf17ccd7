// The multipart parser: no crash, and the same parts however the body is cut.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "api/forms/multipart.h"
#include "core/base/check.h"

namespace {

using namespace skyquilt;

class Recorder final : public api::PartReceiver {
 public:
  Result<void> BeginPart(const api::PartHeader& header) override {
    seen += "<" + header.field + "|" + header.file_name.value_or("-") + ">";
    return {};
  }
  Result<void> PartBytes(std::span<const std::uint8_t> bytes) override {
    seen.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return {};
  }
  Result<void> EndPart() override {
    seen += "</>";
    return {};
  }
  std::string seen;
};

std::string Parse(std::span<const std::uint8_t> body, std::size_t slice) {
  Recorder recorder;
  api::MultipartParser parser("b", recorder);
  while (!body.empty()) {
    const std::size_t count = slice == 0 ? body.size() : std::min(slice, body.size());
    if (!parser.Push(body.first(count))) return recorder.seen + "!";
    body = body.subspan(count);
  }
  return recorder.seen + (parser.Finish() ? "." : "?");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> body(bytes + 1, size - 1);
  SKYQUILT_CHECK(Parse(body, 0) == Parse(body, 1U + bytes[0] % 16U), "the cuts changed the parts");
  static_cast<void>(api::MultipartBoundary(std::string(body.begin(), body.end())));
  return 0;
}
