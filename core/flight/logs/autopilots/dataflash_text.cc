#include "core/flight/logs/autopilots/dataflash_text.h"

#include <cstring>
#include <limits>

namespace skyquilt::flight {
namespace {

constexpr std::string_view kTextCodes = "nNZa";
constexpr DataflashCode kTextNumber{'d', sizeof(double), NumberAt<double>}, kTextWord{'N', sizeof(double)};
// As the log that was converted bounds them.
constexpr std::size_t kHeadLength = 3, kMaxCodes = 16, kMaxName = 4, kMaxLabel = 64;

bool IsFmtLine(const std::vector<std::string_view>& fields) {
  return fields.size() > 5 && fields[0] == "FMT" && ParseInteger(fields[1]) && ParseInteger(fields[2]) &&
         !fields[3].empty() && fields[4].size() <= kMaxCodes;
}

}  // namespace

std::optional<std::uint8_t> DataflashTextWalk::LearnLayout() {
  if (!IsFmtLine(fields_)) return std::nullopt;
  const std::int64_t type = *ParseInteger(fields_[1]);
  if (type < 0 || type > 255 || type == kDataflashFmt) return std::nullopt;
  DataflashLayout layout;
  layout.name = fields_[3].substr(0, kMaxName);
  const std::string_view codes = fields_[4];
  for (std::size_t i = 0; i < codes.size() && i + 5 < fields_.size(); ++i) {
    const bool is_word = kTextCodes.find(codes[i]) != std::string_view::npos;
    layout.fields.push_back({std::string(fields_[i + 5].substr(0, kMaxLabel)),
                             is_word ? &kTextWord : &kTextNumber, i * sizeof(double)});
  }
  layout.length = kHeadLength + layout.fields.size() * sizeof(double);
  DataflashLayout& known = layouts[static_cast<std::size_t>(type)];
  const auto earlier = types_.find(known.name);
  if (earlier != types_.end() && earlier->second == type) types_.erase(earlier);
  types_.insert_or_assign(layout.name, static_cast<std::uint8_t>(type));
  known = std::move(layout);
  return static_cast<std::uint8_t>(type);
}

bool DataflashTextWalk::FillPayload(const DataflashLayout& layout) {
  if (fields_.size() < layout.fields.size() + 1) return false;
  payload_.resize(layout.fields.size() * sizeof(double));
  for (std::size_t i = 0; i < layout.fields.size(); ++i) {
    double value = std::numeric_limits<double>::quiet_NaN();
    if (layout.fields[i].code->number != nullptr) {
      const std::optional<double> number = ParseNumber(fields_[i + 1]);
      // What was measured may be no number in the log itself.
      if (!number && LowerCase(fields_[i + 1]).find("nan") == std::string::npos) return false;
      value = number.value_or(value);
    }
    std::memcpy(payload_.data() + i * sizeof(double), &value, sizeof(double));
  }
  return true;
}

bool LooksLikeDataflashText(LogBytes head) {
  constexpr int kHeadingLines = 200;  // of parameters and the like
  LineReader lines(TextOf(head));
  std::vector<std::string_view> fields;
  std::string_view line;
  for (int i = 0; i < kHeadingLines && lines.Next(line); ++i) {
    if (!line.starts_with("FMT")) continue;
    SplitFields(line, ',', fields);
    if (IsFmtLine(fields)) return true;
  }
  return false;
}

}  // namespace skyquilt::flight
