#include "server/intake/control_sandboxed.h"

#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/pipeline/placing/control_points.h"
#include "server/sandbox/run_sandboxed.h"

namespace skyquilt::server {
namespace {

using ControlInput = nlohmann::json;

constexpr std::int64_t kControlDataBytes = std::int64_t{200} << 20;
constexpr std::int64_t kControlCpuS = 10;
constexpr const char* kControlRefusal =
    "The list of control points could not be read: it took more memory or time than the server gives for it.";

Result<std::string> ReadControl(const std::filesystem::path& path) {
  SKYQUILT_TRY_ASSIGN(const flight::GcpList list, flight::ReadGcpList({"gcp_list.txt", path}));
  return pipeline::ControlJson(list);
}

}  // namespace

Result<std::string> ControlSandboxed(const std::filesystem::path& list) {
  Result<std::string> json = RunSandboxed({.name = "control",
                                           .words = {"verdict", "--parent", std::to_string(getpid()),
                                                     "--cpu-s", std::to_string(kControlCpuS), "--control"},
                                           .input = JsonText(ControlInput(list.string())),
                                           .deadline = std::chrono::seconds(3 * kControlCpuS),
                                           .refusal = kControlRefusal});
  if (json && ParseJson(*json).is_discarded())
    return Error{ErrorCode::kUnprocessable, kControlRefusal, "the control points are not JSON"};
  return json;
}

void ControlHere(std::int64_t cpu_s) {
  const std::filesystem::path list = ParseJson(ReadInput()).get<std::string>();  // by our own server
  SandboxNeeds needs{.limits = {.more_data_bytes = kControlDataBytes, .more_cpu_s = cpu_s}};
  needs.reads.push_back(list);
  BecomeSandboxed(needs);
  TellParent(ReadControl(list));
}

}  // namespace skyquilt::server
