// The contract as a page to read: made from openapi.json, without a script.
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/http/responses.h"
#include "api/routes.h"
#include "core/base/text/json_io.h"
#include "core/base/text/xml_text.h"

namespace skyquilt::api {

extern const std::string_view kOpenApi;  // api/openapi.json

namespace {

using Value = nlohmann::ordered_json;

constexpr const char* kHead = R"(<!doctype html>
<html lang="en"><head>
<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Skyquilt API</title></head><body>
<h1>Skyquilt API</h1>
<p>The same for programs: <a href="openapi.json">openapi.json</a> (OpenAPI 3.1).
Errors are problem documents (RFC 9457).</p>
)";

std::string Parameters(const Value& operation) {
  std::string rows;
  for (const Value& parameter : operation.value("parameters", Value::array())) {
    rows += "<tr><td><code>" + XmlText(parameter.value("name", "")) + "</code></td><td>" +
            XmlText(parameter.value("in", "")) + "</td><td>" + XmlText(parameter.value("description", "")) +
            "</td></tr>\n";
  }
  if (rows.empty()) return "";
  return "<table><tr><th>Parameter</th><th>In</th><th>What</th></tr>\n" + rows + "</table>\n";
}

// Of an object, with what they are: "options.gsd_m" of one within it, "points[].x" of those in a list.
std::string Members(const Value& contract, const Value& schema, const std::string& before = "") {
  if (const std::string place = schema.value("$ref", ""); !place.empty())
    return Members(contract, contract.at(Value::json_pointer(place.substr(1))), before);
  std::string rows;
  const Value members = schema.value("properties", Value::object());
  for (const auto& [name, member] : members.items()) {
    const std::string path = before + name;
    rows += "<tr><td><code>" + XmlText(path) + "</code></td><td>" + XmlText(member.value("description", "")) +
            "</td></tr>\n";
    rows += Members(contract, member, path + ".");
    if (member.contains("items")) rows += Members(contract, member.at("items"), path + "[].");
  }
  return rows;
}

std::string Body(const Value& contract, const Value& operation) {
  const Value content = operation.value("requestBody", Value::object()).value("content", Value::object());
  std::vector<std::pair<std::string, std::string>> bodies;  // what is in them, and their types
  for (const auto& [type, media] : content.items()) {
    const Value schema = media.value("schema", Value::object());
    const std::string rows = Members(contract, schema);
    std::string what = " " + XmlText(schema.value("description", "")) + "</p>\n";
    if (!rows.empty()) what += "<table><tr><th>In the body</th><th>What</th></tr>\n" + rows + "</table>\n";
    const std::string code = " <code>" + XmlText(type) + "</code>";
    if (!bodies.empty() && bodies.back().first == what) {
      bodies.back().second += code;
    } else {
      bodies.emplace_back(what, code);
    }
  }
  std::string text;
  for (const auto& [what, types] : bodies) text += "<p>Body:" + types + what;
  return text;
}

std::string Responses(const Value& operation) {
  std::string items;
  for (const auto& [status, response] : operation.at("responses").items()) {
    if (status == "default") continue;
    std::string types;
    const Value content = response.value("content", Value::object());
    for (const auto& [type, media] : content.items()) types += " <code>" + XmlText(type) + "</code>";
    items += "<li>" + XmlText(status) + " " + XmlText(response.value("description", "")) + types + "</li>\n";
  }
  return "<ul>" + items + "</ul>\n";
}

std::string Page() {
  const Value contract = ParseOrderedJson(kOpenApi);
  std::string page = kHead;
  for (const Value& tag : contract.at("tags")) {
    page += "<h2>" + XmlText(tag.value("description", "")) + "</h2>\n";
    for (const auto& [path, item] : contract.at("paths").items()) {
      for (const auto& [method, operation] : item.items()) {
        if (!operation.is_object() ||
            operation.value("tags", Value::array()) != Value::array({tag.at("name")}))
          continue;
        std::string upper = method;
        for (char& c : upper) c = static_cast<char>(c - 'a' + 'A');
        page += "<h3><code>" + upper + " " + XmlText(path) + "</code></h3>\n<p>" +
                XmlText(operation.value("summary", "")) + "</p>\n";
        if (const std::string more = operation.value("description", ""); !more.empty())
          page += "<p>" + XmlText(more) + "</p>\n";
        page += Parameters(operation) + Body(contract, operation) + Responses(operation);
      }
    }
  }
  return page + "</body></html>\n";
}

}  // namespace

void AddDocsRoute(Router& router, Service&) {
  router
      .AddQuick(Method::kGet, "/docs",
                [](const Request&) {
                  static const std::string kPage = Page();
                  Response response = Text(200, kPage, "text/html; charset=utf-8");
                  response.headers.Add("Content-Security-Policy",
                                       "default-src 'none'; frame-ancestors 'none'");
                  return response;
                })
      .scope = kEverybody;
}

}  // namespace skyquilt::api
