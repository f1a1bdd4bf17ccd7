#include "api/http/http_message.h"

#include <algorithm>
#include <array>

#include "core/base/check.h"

namespace skyquilt::api {
namespace {

char LowerLetter(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; }

}  // namespace

bool EqualsIgnoringCase(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return LowerLetter(x) == LowerLetter(y); });
}

const char* MethodName(Method method) {
  constexpr std::array kNames = {"GET", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"};
  return kNames[static_cast<std::size_t>(method)];
}

void Headers::Set(std::string_view name, std::string value) {
  for (auto& [known, old] : list_) {
    if (EqualsIgnoringCase(known, name)) {
      old = std::move(value);
      return;
    }
  }
  list_.emplace_back(std::string(name), std::move(value));
}

void Headers::AddVary(std::string_view field) {
  std::string fields(Find("Vary"));
  if (!fields.empty()) fields += ", ";
  Set("Vary", fields.append(field));
}

void Headers::Remove(std::string_view name) {
  std::erase_if(list_, [&](const auto& header) { return EqualsIgnoringCase(header.first, name); });
}

std::string_view Headers::Find(std::string_view name) const {
  for (const auto& [known, value] : list_) {
    if (EqualsIgnoringCase(known, name)) return value;
  }
  return {};
}

bool Headers::Has(std::string_view name) const {
  return std::any_of(list_.begin(), list_.end(),
                     [&](const auto& h) { return EqualsIgnoringCase(h.first, name); });
}

const std::string& Request::Parameter(std::string_view name) const {
  for (const auto& [known, value] : parameters) {
    if (known == name) return value;
  }
  SKYQUILT_CHECK(false, "a handler asked for a parameter that its route does not have");
}

std::optional<std::string_view> Request::Query(std::string_view name) const {
  for (const auto& [known, value] : query) {
    if (known == name) return value;
  }
  return std::nullopt;
}

}  // namespace skyquilt::api
