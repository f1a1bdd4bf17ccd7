#include "api/nodeodm/node_new_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/flights/flights.h"
#include "api/forms/multipart.h"
#include "api/http/parameters.h"
#include "api/http/target.h"
#include "api/json/json_codec.h"
#include "api/json/json_text.h"
#include "api/nodeodm/nodeodm.h"
#include "api/webhooks/webhooks.h"
#include "core/base/text/json_io.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::api {
namespace {

class FieldCollector final : public PartReceiver {
 public:
  Result<void> BeginPart(const PartHeader& header) override {
    text_ = nullptr;
    if (header.file_name) return {};
    const auto [field, is_new] = fields.try_emplace(header.field);
    if (is_new) text_ = &field->second;
    return {};
  }
  Result<void> PartBytes(std::span<const std::uint8_t> bytes) override {
    if (text_ != nullptr) text_->append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return {};
  }
  Result<void> EndPart() override { return {}; }

  NodeFields fields;

 private:
  std::string* text_ = nullptr;
};

Result<NodeFields> FromMultipart(std::string_view content_type, const std::string& body) {
  SKYQUILT_TRY_ASSIGN(const std::string boundary, MultipartBoundary(content_type));
  FieldCollector collector;
  MultipartParser parser(boundary, collector);
  SKYQUILT_TRY(parser.Push({reinterpret_cast<const std::uint8_t*>(body.data()), body.size()}));
  SKYQUILT_TRY(parser.Finish());
  return std::move(collector.fields);
}

Result<NodeFields> FromJson(const std::string& body) {
  SKYQUILT_TRY(CheckJsonText(body));
  const auto parsed = ParseOrderedJson(body);
  if (!parsed.is_object()) return Error{ErrorCode::kInvalidArgument, "The body is not a JSON object."};
  NodeFields fields;
  for (const auto& [name, value] : parsed.items()) {
    if (value.is_null()) continue;
    fields.emplace(name, value.is_string() ? value.get<std::string>() : JsonText(value));
  }
  return fields;
}

Result<NodeFields> FromUrlencoded(const std::string& body) {
  SKYQUILT_TRY_ASSIGN(const auto pairs, ParseQuery(body));
  NodeFields fields;
  for (const auto& [name, value] : pairs) fields.emplace(name, value);
  return fields;
}

std::string NewNodeUuid() {
  std::array<std::uint8_t, 16> bytes{};
  storage::FillWithRandom(bytes);
  bytes[6] = static_cast<std::uint8_t>((bytes[6] & 0x0f) | 0x40);
  bytes[8] = static_cast<std::uint8_t>((bytes[8] & 0x3f) | 0x80);
  std::string uuid;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) uuid += '-';
    uuid += fmt::format("{:02x}", bytes[i]);
  }
  return uuid;
}

// Clients send names in their file systems' encodings, which PostgreSQL does not take.
std::string InUtf8(const std::string& text) {
  return ParseJson(JsonText(nlohmann::json(text))).get<std::string>();
}

// A webhook that cannot be told is no reason to refuse the task.
void SetWebhook(const Service& service, const std::string& url, NewTask& task) {
  if (url.empty()) return;
  if (!service.sends_webhooks) {
    task.notes.push_back(NodeNote("The webhook " + url +
                                  " will not be told: this node speaks to nobody by itself. Its operator "
                                  "changes that with serve --webhooks."));
  } else if (const Result<void> checked = CheckWebhookUrl(url); !checked) {
    task.notes.push_back(NodeNote("The webhook " + url + " will not be told: " + checked.error().message));
  } else {
    task.webhook = url;
  }
}

// Clients take longer names than a flight may have, which is no reason to refuse their photos.
void SetName(const std::string& sent, NewTask& task) {
  std::string name = InUtf8(sent);
  if (name.size() > kMaxFlightNameBytes) {
    name = CutToBytes(name, kMaxFlightNameBytes);
    task.notes.push_back(NodeNote(fmt::format("The name was cut to {} bytes: here it has at most {}.",
                                              name.size(), kMaxFlightNameBytes)));
  }
  task.name = name.empty() ? DefaultFlightName(storage::Now()) : std::move(name);
}

Result<void> SetOutputs(const std::string& text, NewTask& task) {
  if (text.empty()) return {};
  SKYQUILT_TRY(CheckJsonText(text));
  const auto list = ParseJson(text);
  bool is_good = list.is_array();
  for (const auto& path : list) is_good = is_good && path.is_string();
  if (!is_good) {
    return Error{ErrorCode::kInvalidArgument,
                 "Invalid outputs: give a JSON list of paths as all.zip has them."};
  }
  task.outputs = JsonText(list);
  return {};
}

}  // namespace

Result<NodeFields> ParseNodeFields(std::string_view content_type, const std::string& body) {
  const std::string_view kind = content_type.substr(0, content_type.find_first_of("; "));
  if (body.find_first_not_of(" \t\r\n") == std::string::npos) return NodeFields();
  if (EqualsIgnoringCase(kind, "multipart/form-data")) return FromMultipart(content_type, body);
  if (EqualsIgnoringCase(kind, "application/json")) return FromJson(body);
  return FromUrlencoded(body);
}

std::string NodeField(const NodeFields& fields, std::string_view name) {
  const auto found = fields.find(name);
  return found == fields.end() ? std::string() : found->second;
}

std::string NodeNote(std::string text) {
  constexpr std::size_t kMaxBytes = 500;
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c >= 0 && c < ' '; }, ' ');
  text = InUtf8(text);
  return text.size() > kMaxBytes ? CutToBytes(text, kMaxBytes) + "..." : text;
}

std::vector<std::string> NodeNotes(const std::vector<std::string>& unknown_options) {
  std::vector<std::string> notes;
  for (const std::string& name : unknown_options)
    notes.push_back(NodeNote(fmt::format("The option {} is not known here and has no effect.", name)));
  return notes;
}

std::int64_t NodeNowMs() { return storage::ToUs(storage::Now()) / 1000; }

storage::NodeTask NewTask::Record(const std::string& flight_id) const {
  storage::NodeTask record;
  record.uuid = uuid;
  record.flight_id = flight_id;
  record.options = choice.shown;
  record.created_ms = created_ms;
  record.webhook = webhook;
  record.outputs = outputs;
  for (const std::string& note : notes) record.notes += note + "\n";
  return record;
}

Result<NewTask> NewTaskFrom(Service& service, const Request& request, const NodeFields& fields) {
  NewTask task;
  const std::string_view wanted = request.headers.Find("set-uuid");
  task.uuid = NewNodeUuid();
  if (!wanted.empty()) {
    const std::optional<std::string> uuid = NodeUuid(wanted);
    if (!uuid)
      return Error{ErrorCode::kInvalidArgument, "Invalid uuid: set-uuid must be a UUID of version 1 to 7."};
    const Result<storage::NodeTask> taken = service.node_tasks.Find(*uuid);
    if (taken) return Error{ErrorCode::kConflict, "Invalid uuid: it is in use."};
    if (taken.error().code != ErrorCode::kNotFound) return taken.error();
    task.uuid = *uuid;
  }
  if (NodeField(fields, "zipurl") != "") {
    return Error{ErrorCode::kUnprocessable,
                 "This node fetches nothing by itself (zipurl). Upload the photos."};
  }
  SKYQUILT_TRY_ASSIGN(const NodeChoice choice, ParseNodeOptions(NodeField(fields, "options")));
  task.choice = choice;
  task.notes = NodeNotes(choice.unknown);
  SetWebhook(service, NodeField(fields, "webhook"), task);
  SKYQUILT_TRY(SetOutputs(NodeField(fields, "outputs"), task));
  SetName(NodeField(fields, "name"), task);
  const Result<storage::FlightChange> checked =
      ParseFlightFields(JsonText(nlohmann::ordered_json{{"name", task.name}}));
  if (!checked) return checked.error();
  const std::string date = NodeField(fields, "dateCreated");
  task.created_ms = ParseNumber<std::int64_t>(date).value_or(NodeNowMs());
  return task;
}

}  // namespace skyquilt::api
