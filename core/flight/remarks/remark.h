// Remark: one thing that whoever asked for a map is to know, as a code with numbers and names. Whoever
// decides looks at the code. The English sentence is made by InWords (remark_words.h) alone, from
// remarks_on_*.inc; those of the page stand in web/src/languages/*/remarks.js and failures.js. A value's name
// ends with its unit (`apart_m`), or with `_words` where it is English without a code. Values; any thread.
#pragma once

#include <concepts>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace skyquilt::flight {

// What a remark says, without its values: the lists hold each code with its name in JSON and its English
// sentence; tests/web/languages/remarks.test.js holds the words of the page to them.
enum class RemarkCode : std::uint16_t {
#define REMARK(code, ...) code,
#include "core/flight/remarks/remarks.inc"
#undef REMARK
};

struct Remark;

// A number, a name as it was given, or what is to be said within the sentence.
struct RemarkValue {
  std::variant<std::int64_t, double, std::string, std::vector<Remark>> is;

  RemarkValue(std::integral auto number);
  RemarkValue(double number);
  RemarkValue(std::string name);
  RemarkValue(std::string_view name);
  RemarkValue(const char* name);
  RemarkValue(Remark within);
  RemarkValue(std::vector<Remark> within);
  bool operator==(const RemarkValue&) const = default;
};

struct Remark {
  RemarkCode code = RemarkCode::kText;
  std::map<std::string, RemarkValue> values;

  Remark(RemarkCode its_code, std::map<std::string, RemarkValue> its_values = {})
      : code(its_code), values(std::move(its_values)) {}
  Remark(std::string text) : values{{"text_words", std::move(text)}} {}
  Remark(const char* text) : Remark(std::string(text)) {}
  bool operator==(const Remark&) const = default;
};

// Here, where a Remark is complete: not every compiler takes them above.
RemarkValue::RemarkValue(std::integral auto number) : is(static_cast<std::int64_t>(number)) {}
inline RemarkValue::RemarkValue(double number) : is(number) {}
inline RemarkValue::RemarkValue(std::string name) : is(std::move(name)) {}
inline RemarkValue::RemarkValue(std::string_view name) : is(std::string(name)) {}
inline RemarkValue::RemarkValue(const char* name) : is(std::string(name)) {}
inline RemarkValue::RemarkValue(Remark within) : is(std::vector<Remark>{std::move(within)}) {}
inline RemarkValue::RemarkValue(std::vector<Remark> within) : is(std::move(within)) {}

}  // namespace skyquilt::flight
