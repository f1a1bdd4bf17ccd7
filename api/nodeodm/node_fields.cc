#include "api/nodeodm/node_fields.h"

#include <nlohmann/json.hpp>

#include "api/forms/multipart.h"
#include "api/http/http_message.h"
#include "api/http/target.h"
#include "api/json/json_text.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

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
  if (!parsed.is_object()) return Error{ErrorCode::kInvalidArgument, "The body is not a JSON object.", ""};
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

}  // namespace skyquilt::api
