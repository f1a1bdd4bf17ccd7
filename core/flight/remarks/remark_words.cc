#include "core/flight/remarks/remark_words.h"

#include <fmt/args.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace skyquilt::flight {
namespace {

constexpr auto kSentences = std::to_array<RemarkSentence>({
#define REMARK(code, ...) {RemarkCode::code, __VA_ARGS__},
#include "core/flight/remarks/remarks.inc"
#undef REMARK
});

struct SaidNumber {
  double is = 0.0;
};

std::string GroupedDigits(double number) {
  std::string digits = fmt::format("{:.0f}", number);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3)
    digits.insert(static_cast<std::size_t>(at), ",");
  return digits;
}

// "90 seconds", "12 minutes".
std::string TimeInWords(double seconds) {
  return seconds < 120.0 ? fmt::format("{:.0f} seconds", seconds)
                         : fmt::format("{:.0f} minutes", seconds / 60.0);
}

bool IsOne(const Remark& remark, std::string_view counted) {
  const auto value = remark.values.find(std::string(counted));
  if (value == remark.values.end()) return false;
  const auto* number = std::get_if<std::int64_t>(&value->second.is);
  return number != nullptr && *number == 1;
}

}  // namespace
}  // namespace skyquilt::flight

// As a number, or as a length or a time in words.
template <>
struct fmt::formatter<skyquilt::flight::SaidNumber> : fmt::formatter<double> {
  constexpr auto parse(format_parse_context& context) {
    const auto begin = context.begin();
    const std::string_view spec(begin, static_cast<std::size_t>(context.end() - begin));
    using Named = std::pair<std::string_view, std::string (*)(double)>;
    for (const auto& [name, words] : {Named{"length", &skyquilt::flight::LengthInWords},
                                      Named{"duration", &skyquilt::flight::TimeInWords}}) {
      if (!spec.starts_with(name)) continue;
      words_ = words;
      return begin + name.size();
    }
    return fmt::formatter<double>::parse(context);
  }
  auto format(const skyquilt::flight::SaidNumber& number, format_context& context) const {
    if (words_ == nullptr) return fmt::formatter<double>::format(number.is, context);
    return fmt::format_to(context.out(), "{}", words_(number.is));
  }

 private:
  std::string (*words_)(double) = nullptr;
};

namespace skyquilt::flight {

std::string LengthInWords(double metres) {
  if (metres < 100.0) return fmt::format("{:.1f} m", metres);
  if (metres < 10'000.0) return GroupedDigits(metres) + " m";
  return GroupedDigits(metres / 1000.0) + " km";
}

Remark InARow(std::vector<Remark> remarks) {
  if (remarks.size() < 2) return remarks.empty() ? Remark("") : std::move(remarks.front());
  std::vector<Remark> then;
  for (std::size_t i = 1; i < remarks.size(); ++i) {
    then.push_back(i == 1 ? std::move(remarks[i])
                          : Remark(RemarkCode::kThen, {{"said", std::move(remarks[i])}}));
  }
  return {RemarkCode::kSentences, {{"first", std::move(remarks.front())}, {"then", std::move(then)}}};
}

std::span<const RemarkSentence> RemarkSentences() { return kSentences; }

std::string_view NameOf(RemarkCode code) { return kSentences[static_cast<std::size_t>(code)].name; }

std::optional<RemarkCode> RemarkCodeOf(std::string_view name) {
  const auto found = std::find_if(kSentences.begin(), kSentences.end(),
                                  [&](const RemarkSentence& one) { return one.name == name; });
  if (found == kSentences.end()) return std::nullopt;
  return found->code;
}

std::string InWords(const Remark& remark) {
  const RemarkSentence& said = kSentences[static_cast<std::size_t>(remark.code)];
  fmt::dynamic_format_arg_store<fmt::format_context> values;
  for (const auto& [name, value] : remark.values) {
    if (const auto* whole = std::get_if<std::int64_t>(&value.is)) {
      values.push_back(fmt::arg(name.c_str(), *whole));
    } else if (const auto* number = std::get_if<double>(&value.is)) {
      values.push_back(fmt::arg(name.c_str(), SaidNumber{*number}));
    } else if (const auto* text = std::get_if<std::string>(&value.is)) {
      values.push_back(fmt::arg(name.c_str(), *text));
    } else {
      std::string within;
      for (const Remark& one : std::get<std::vector<Remark>>(value.is)) within += InWords(one);
      values.push_back(fmt::arg(name.c_str(), within));
    }
  }
  try {
    return fmt::vformat(said.one.empty() || !IsOne(remark, said.counted) ? said.sentence : said.one, values);
  } catch (const fmt::format_error&) {
    return std::string(said.name);
  }
}

std::vector<std::string> InWords(const std::vector<Remark>& remarks) {
  std::vector<std::string> sentences;
  for (const Remark& remark : remarks) sentences.push_back(InWords(remark));
  return sentences;
}

std::string InOneLine(const std::vector<Remark>& remarks) {
  return fmt::format("{}", fmt::join(InWords(remarks), "; "));
}

}  // namespace skyquilt::flight
