// The NodeODM-compatible node at the root paths, so that WebODM, PyODM, CloudODM and ClusterODM work with
// Skyquilt unmodified. Its contract differs from our own API's: refusals are 200 with {"error": text}
// (clients take any other status for a passing fault and try again).
// https://github.com/OpenDroneMap/NodeODM/blob/master/docs
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "api/common/node_answers.h"
#include "api/service.h"

namespace skyquilt::api {

// A name that its clients take: lower-case letters and digits, at most 32.
bool IsNodeEngine(std::string_view name);

// What these files share.
// The committed task of this name. Errors: kNotFound with the contract's text.
Result<storage::NodeTask> FindNodeTask(Service& service, std::string_view uuid);
// What is to be known of the task, and what its latest job went through, one line each.
Result<std::vector<std::string>> NodeOutput(Service& service, const storage::NodeTask& task);

// What the webhook of a task is told when a job of it has ended. kNotFound: the task is gone, or was started
// again.
Result<std::string> NodeWebhookBody(Service& service, const std::string& uuid, const std::string& job_id);

}  // namespace skyquilt::api
