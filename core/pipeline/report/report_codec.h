// JsonOf and ReportOf: the reports of the stages as JSON and back, by the one list of their fields
// (report_fields.h). `Json` is whichever JSON library's value the including source works with. Numbers are
// written so that they are read again exactly; one that JSON cannot have (not a number, infinite) is written
// as null and read as not a number. Reading is strict: what is missing, of another kind, out of range or an
// unknown word throws Json's own exceptions, which the caller turns into an error. Any thread.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/error_code.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark_json.h"
#include "core/flight/remarks/remark_words.h"
#include "core/pipeline/report/report_fields.h"

namespace skyquilt::pipeline {

template <typename Value>
inline constexpr bool kIsList = false;
template <typename Element>
inline constexpr bool kIsList<std::vector<Element>> = true;

// Those that reports have, each with its words.
inline std::string_view WordOf(alignment::PhotoFault fault) { return alignment::FaultName(fault); }
inline std::string_view WordOf(alignment::Placement placement) { return alignment::PlacementName(placement); }
inline const auto& AllOf(alignment::PhotoFault) { return alignment::kAllPhotoFaults; }
inline auto AllOf(alignment::Placement) {
  return std::array{alignment::Placement::kAligned, alignment::Placement::kPoseOnly};
}

template <typename Json, typename Value>
Json JsonOf(const Value& value);

// Visits fields to write them.
template <typename Json>
class FieldWriter {
 public:
  template <typename Value>
  void operator()(const char* name, const Value& value) {
    json_[name] = JsonOf<Json>(value);
  }
  template <typename List>
  void IfAny(const char* name, const List& list) {
    if (!list.empty()) (*this)(name, list);
  }
  template <typename Value>
  void IfKnown(const char* name, const std::optional<Value>& value) {
    if (value) (*this)(name, *value);
  }
  void Remarked(const char* words, const char* codes, const std::vector<flight::Remark>& remarks) {
    json_[words] = flight::InOneLine(remarks);
    json_[codes] = flight::JsonOfRemarks<Json>(remarks);
  }
  void Remarked(const char* words, const char* code, const std::optional<flight::Remark>& remark) {
    json_[words] = remark ? flight::InWords(*remark) : "";
    if (remark) json_[code] = flight::JsonOfRemark<Json>(*remark);
  }
  void OneOf(const char* name, bool is_so, const char* if_so, const char* if_not) {
    json_[name] = is_so ? if_so : if_not;
  }
  template <typename Fields>
  void Group(const char* name, Fields fields) {
    FieldWriter part;
    fields(part);
    json_[name] = part.Take();
  }
  template <typename List, typename Fields>
  void Each(const char* name, const List& list, Fields fields) {
    json_[name] = Json::array();
    for (const auto& one : list) {
      FieldWriter part;
      fields(one, part);
      json_[name].push_back(part.Take());
    }
  }
  Json Take() { return std::move(json_); }

 private:
  Json json_ = Json::object();
};

template <typename Json, typename Value>
Json JsonOf(const Value& value) {
  if constexpr (std::same_as<Value, double>) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
  } else if constexpr (std::is_arithmetic_v<Value> || std::same_as<Value, std::string>) {
    return Json(value);
  } else if constexpr (std::same_as<Value, flight::Remark>) {
    return Json(flight::InWords(value));
  } else if constexpr (std::same_as<Value, std::optional<double>>) {
    return value ? Json(*value) : Json(nullptr);
  } else if constexpr (std::is_enum_v<Value>) {
    return Json(WordOf(value));
  } else if constexpr (std::same_as<Value, Eigen::Vector3d>) {
    return Json::array({value.x(), value.y(), value.z()});
  } else if constexpr (kIsList<Value>) {
    Json list = Json::array();
    for (const auto& one : value) list.push_back(JsonOf<Json>(one));
    return list;
  } else {
    FieldWriter<Json> fields;
    VisitFields(value, fields);
    return fields.Take();
  }
}

template <typename Json>
[[noreturn]] void ThrowDamaged(const char* what) {
  throw Json::other_error::create(500, what, nullptr);
}

template <typename Json, typename Value>
void ReadJson(const Json& json, Value& value);

// Visits fields to read them.
template <typename Json>
class FieldReader {
 public:
  explicit FieldReader(const Json& json) : json_(json) {}

  template <typename Value>
  void operator()(const char* name, Value& value) const {
    ReadJson(json_.at(name), value);
  }
  template <typename List>
  void IfAny(const char* name, List& list) const {
    list.clear();
    if (json_.contains(name)) (*this)(name, list);
  }
  template <typename Value>
  void IfKnown(const char* name, std::optional<Value>& value) const {
    value.reset();
    if (json_.contains(name)) (*this)(name, value.emplace());
  }
  void Remarked(const char* words, const char* codes, std::vector<flight::Remark>& remarks) const {
    json_.at(words).template get_ref<const std::string&>();
    remarks = flight::RemarksOfJson(json_.at(codes));
  }
  void Remarked(const char* words, const char* code, std::optional<flight::Remark>& remark) const {
    json_.at(words).template get_ref<const std::string&>();
    remark.reset();
    if (json_.contains(code)) remark = flight::RemarkOfJson(json_.at(code));
  }
  void OneOf(const char* name, bool& is_so, const char* if_so, const char* if_not) const {
    const Json& word = json_.at(name);
    if (word != if_so && word != if_not) ThrowDamaged<Json>("a word is none of the two it may be");
    is_so = word == if_so;
  }
  template <typename Fields>
  void Group(const char* name, Fields fields) const {
    FieldReader part(json_.at(name));
    fields(part);
  }
  template <typename List, typename Fields>
  void Each(const char* name, List& list, Fields fields) const {
    const Json& all = json_.at(name);
    if (!all.is_array()) ThrowDamaged<Json>("a list is none");
    list.clear();
    for (const Json& one : all) {
      FieldReader part(one);
      fields(list.emplace_back(), part);
    }
  }

 private:
  const Json& json_;
};

template <typename Json, typename Value>
void ReadJson(const Json& json, Value& value) {
  if constexpr (std::same_as<Value, int>) {
    constexpr double kMaxCount = std::numeric_limits<int>::max();
    if (!json.is_number_integer() || std::abs(json.template get<double>()) > kMaxCount)
      ThrowDamaged<Json>("a count is none");
    value = json.template get<int>();
  } else if constexpr (std::same_as<Value, double>) {
    if (!json.is_number() && !json.is_null()) ThrowDamaged<Json>("a number is none");
    value = json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.template get<double>();
  } else if constexpr (std::same_as<Value, bool> || std::same_as<Value, std::string>) {
    value = json.template get<Value>();
  } else if constexpr (std::same_as<Value, std::optional<double>>) {
    value.reset();
    if (!json.is_null()) ReadJson(json, value.emplace());
  } else if constexpr (std::is_enum_v<Value>) {
    const auto& word = json.template get_ref<const std::string&>();
    const auto all = AllOf(Value{});
    const auto found = std::find_if(all.begin(), all.end(), [&](Value one) { return WordOf(one) == word; });
    if (found == all.end()) ThrowDamaged<Json>("a word is unknown");
    value = *found;
  } else if constexpr (std::same_as<Value, Eigen::Vector3d>) {
    if (!json.is_array() || json.size() != 3) ThrowDamaged<Json>("a place has not three numbers");
    for (int axis = 0; axis < 3; ++axis) ReadJson(json[static_cast<std::size_t>(axis)], value[axis]);
  } else if constexpr (kIsList<Value>) {
    if (!json.is_array()) ThrowDamaged<Json>("a list is none");
    value.clear();
    for (const Json& one : json) {
      if constexpr (std::same_as<Value, std::vector<flight::Remark>>) {
        value.push_back(one.template get<std::string>());  // its sentence alone is kept
      } else {
        ReadJson(one, value.emplace_back());
      }
    }
  } else {
    FieldReader<Json> fields(json);
    VisitFields(value, fields);
  }
}

// Photos that were left out, as they are told of; the way back is nobody's.
template <typename Json>
Json JsonOfLeftOut(const std::vector<flight::LeftOutPhoto>& left_out) {
  Json list = Json::array();
  for (const flight::LeftOutPhoto& photo : left_out) {
    list.push_back({{"name", photo.name},
                    {"code", ErrorCodeName(photo.code)},
                    {"reason", flight::InWords(photo.reason)},
                    {"remark", flight::JsonOfRemark<Json>(photo.reason)}});
  }
  return list;
}

template <typename Report, typename Json>
Report ReportOf(const Json& json) {
  Report report;
  ReadJson(json, report);
  return report;
}

}  // namespace skyquilt::pipeline
