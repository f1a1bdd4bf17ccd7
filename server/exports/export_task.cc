#include "server/exports/export_task.h"

#include <nlohmann/json.hpp>

#include "core/base/text/json_io.h"
#include "server/sandbox/message_checks.h"

namespace skyquilt::server {

std::string ToText(const ExportTask& task) {
  const nlohmann::json json = {{"map_dir", task.map_dir.string()},
                               {"work_dir", task.work_dir.string()},
                               {"out_name", task.out_name},
                               {"request", task.request},
                               {"threads", task.threads},
                               {"memory_bytes", task.memory_bytes},
                               {"cpu_s", task.cpu_s},
                               {"file_bytes", task.file_bytes}};
  return JsonText(json);
}

Result<ExportTask> ParseExportTask(std::string_view text) {
  try {
    const nlohmann::json json = ParseJson(text);
    ExportTask task;
    task.map_dir = json.at("map_dir").get<std::string>();
    task.work_dir = json.at("work_dir").get<std::string>();
    task.out_name = json.at("out_name");
    task.request = json.at("request");
    task.threads = json.at("threads");
    task.memory_bytes = json.at("memory_bytes");
    task.cpu_s = json.at("cpu_s");
    task.file_bytes = json.at("file_bytes");
    return task;
  } catch (const nlohmann::json::exception& broken) {
    return Untrue(broken.what());
  }
}

}  // namespace skyquilt::server
