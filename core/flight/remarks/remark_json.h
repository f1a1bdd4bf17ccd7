// Remarks in JSON: a code by its name, and its values, of which what is to be said within the sentence is a
// list of remarks. `Json` is whichever JSON library's value the including source works with; what is of
// another kind, a code that is not known, or remarks within each other without end throw its own exceptions.
// Any thread.
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/text/json_io.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {

template <typename Json>
Json JsonOfRemark(const Remark& remark) {
  Json values = Json::object();
  for (const auto& [name, value] : remark.values) {
    values[name] = std::visit(
        [](const auto& is) {
          if constexpr (std::is_same_v<std::decay_t<decltype(is)>, std::vector<Remark>>) {
            Json within = Json::array();
            for (const Remark& one : is) within.push_back(JsonOfRemark<Json>(one));
            return within;
          } else {
            return Json(is);
          }
        },
        value.is);
  }
  return {{"code", NameOf(remark.code)}, {"values", std::move(values)}};
}

template <typename Json>
Json JsonOfRemarks(const std::vector<Remark>& remarks) {
  Json all = Json::array();
  for (const Remark& one : remarks) all.push_back(JsonOfRemark<Json>(one));
  return all;
}

// More deeply within each other than any that are made.
inline constexpr int kMaxRemarkDepth = 16;

template <typename Json>
Remark RemarkOfJson(const Json& json, int depth = 0) {
  if (depth > kMaxRemarkDepth) throw Json::other_error::create(500, "remarks go too deep", nullptr);
  const auto code = RemarkCodeOf(json.at("code").template get_ref<const std::string&>());
  if (!code) throw Json::other_error::create(500, "a remark is not known", nullptr);
  Remark remark(*code);
  for (const auto& [name, value] : json.at("values").template get_ref<const typename Json::object_t&>()) {
    if (value.is_number_integer()) {
      remark.values.emplace(name, value.template get<std::int64_t>());
    } else if (value.is_number()) {
      remark.values.emplace(name, value.template get<double>());
    } else if (value.is_array()) {
      std::vector<Remark> within;
      for (const Json& one : value) within.push_back(RemarkOfJson<Json>(one, depth + 1));
      remark.values.emplace(name, std::move(within));
    } else {
      remark.values.emplace(name, value.template get<std::string>());
    }
  }
  return remark;
}

template <typename Json>
std::vector<Remark> RemarksOfJson(const Json& json) {
  std::vector<Remark> remarks;
  for (const Json& one : json) remarks.push_back(RemarkOfJson<Json>(one));
  return remarks;
}

// What a table keeps of an error's reason (storage/jobs/job_rows.h), in an answer; null where it keeps none.
template <typename Json>
Json ReasonValue(const std::string& kept) {
  const Json reason = kept.empty() ? Json() : Json(ParseOrderedJson(kept));
  return reason.is_object() ? reason : Json();
}

}  // namespace skyquilt::flight
