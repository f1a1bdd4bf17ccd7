#include "core/flight/logs/autopilots/dataflash_walk.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/flight/logs/formats.h"

namespace skyquilt::flight {
namespace {

std::string_view FixedText(const std::uint8_t* from, std::size_t most) {
  std::size_t size = 0;
  while (size < most && from[size] != 0) ++size;
  return {reinterpret_cast<const char*>(from), size};
}

double HalfFloatAt(const std::uint8_t* from) {
  const auto bits = LoadLittle<std::uint16_t>(from);
  const int exponent = bits >> 10 & 31;
  const double fraction = bits & 1023;
  const double sign = bits >> 15 ? -1.0 : 1.0;
  if (exponent == 31) return std::numeric_limits<double>::quiet_NaN();
  if (exponent == 0) return sign * std::ldexp(fraction, -24);
  return sign * std::ldexp(1024.0 + fraction, exponent - 25);
}

constexpr double kHundredths = 0.01;
constexpr std::array kCodes = {DataflashCode{'b', 1, NumberAt<std::int8_t>},
                               DataflashCode{'B', 1, NumberAt<std::uint8_t>},
                               DataflashCode{'M', 1, NumberAt<std::uint8_t>},
                               DataflashCode{'h', 2, NumberAt<std::int16_t>},
                               DataflashCode{'H', 2, NumberAt<std::uint16_t>},
                               DataflashCode{'c', 2, NumberAt<std::int16_t>, kHundredths},
                               DataflashCode{'C', 2, NumberAt<std::uint16_t>, kHundredths},
                               DataflashCode{'g', 2, HalfFloatAt},
                               DataflashCode{'i', 4, NumberAt<std::int32_t>},
                               DataflashCode{'I', 4, NumberAt<std::uint32_t>},
                               DataflashCode{'e', 4, NumberAt<std::int32_t>, kHundredths},
                               DataflashCode{'E', 4, NumberAt<std::uint32_t>, kHundredths},
                               DataflashCode{'L', 4, NumberAt<std::int32_t>, 1e-7},
                               DataflashCode{'f', 4, NumberAt<float>},
                               DataflashCode{'d', 8, NumberAt<double>},
                               DataflashCode{'q', 8, NumberAt<std::int64_t>},
                               DataflashCode{'Q', 8, NumberAt<std::uint64_t>},
                               DataflashCode{'n', 4},
                               DataflashCode{'N', 16},
                               DataflashCode{'Z', 64},
                               DataflashCode{'a', 64}};

}  // namespace

const DataflashField* DataflashLayout::Find(const std::vector<std::string_view>& names) const {
  for (const std::string_view wanted : names) {
    for (const DataflashField& field : fields) {
      if (field.name == wanted && field.code->number != nullptr) return &field;
    }
  }
  return nullptr;
}

bool DataflashWalk::LearnLayout(const std::uint8_t* payload, int& type) {
  type = payload[0];
  DataflashLayout layout;
  layout.length = payload[1];
  layout.name = FixedText(payload + 2, 4);
  const std::string_view codes = FixedText(payload + 6, 16);
  std::string_view labels = FixedText(payload + 22, 64);
  if (type == kDataflashFmt || layout.length < 3 || layout.name.empty()) return false;
  const bool printable =
      std::all_of(layout.name.begin(), layout.name.end(), [](char c) { return c > ' ' && c < 127; });
  if (!printable) return false;
  std::size_t offset = 0;
  for (const char code : codes) {
    const std::size_t comma = std::min(labels.find(','), labels.size());
    const auto* known = std::find_if(kCodes.begin(), kCodes.end(),
                                     [&](const DataflashCode& each) { return each.letter == code; });
    if (known == kCodes.end()) {
      offset = 256;  // an unknown code: nothing behind it can be placed
      break;
    }
    layout.fields.push_back({std::string(labels.substr(0, comma)), known, offset});
    labels.remove_prefix(std::min(labels.size(), comma + 1));
    offset += known->size;
  }
  std::erase_if(layout.fields, [&](const DataflashField& field) {
    return field.offset + field.code->size + 3 > layout.length;
  });
  if (offset + 3 != layout.length && offset != 256) layout.fields.clear();
  layouts[static_cast<std::size_t>(type)] = std::move(layout);
  return true;
}

bool DataflashWalk::IsHead(LogBytes bytes, std::size_t at) const {
  return bytes.size() - at >= 3 && bytes[at] == 0xA3 && bytes[at + 1] == 0x95 &&
         (bytes[at + 2] == kDataflashFmt || layouts[bytes[at + 2]].length > 0);
}

// After damage, a head counts only when another head or the end of the file follows its message.
std::size_t DataflashWalk::FindNext(LogBytes bytes, std::size_t from) const {
  while (from + 3 <= bytes.size()) {
    const void* found = std::memchr(bytes.data() + from, 0xA3, bytes.size() - from);
    if (found == nullptr) return bytes.size();
    from = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes.data());
    if (IsHead(bytes, from)) {
      const std::uint8_t type = bytes[from + 2];
      const std::size_t end = from + (type == kDataflashFmt ? kDataflashFmtLength : layouts[type].length);
      if (end >= bytes.size() || (bytes[end] == 0xA3 && (end + 1 == bytes.size() || bytes[end + 1] == 0x95)))
        return from;
    }
    ++from;
  }
  return bytes.size();
}

namespace {

constexpr std::string_view kTextCodes = "nNZa";
constexpr DataflashCode kTextNumber{'d', sizeof(double), NumberAt<double>}, kTextWord{'N', sizeof(double)};
// As the log that was converted bounds them.
constexpr std::size_t kHeadLength = 3, kMaxCodes = 16, kMaxName = 4, kMaxLabel = 64;

// What was measured may be no number in the log itself: "nan", "-nan", "nan(ind)", "1.#QNAN".
bool IsNoNumber(std::string_view field) {
  std::string word = LowerCase(field);
  std::erase_if(word, [](char c) { return c == '-' || c == '+' || c == ' '; });
  return word.starts_with("nan") || word.starts_with("1.#");
}

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
      if (!number && !IsNoNumber(fields_[i + 1])) return false;
      value = number.value_or(value);
    }
    std::memcpy(payload_.data() + i * sizeof(double), &value, sizeof(double));
  }
  return true;
}

bool LooksLikeDataflashText(LogBytes head) {
  constexpr int kHeadingLines = 200;  // of parameters and the like
  std::vector<std::string_view> fields;
  return HasLine(TextOf(head), kHeadingLines, [&](std::string_view line) {
    if (!line.starts_with("FMT")) return false;
    SplitFields(line, ',', fields);
    return IsFmtLine(fields);
  });
}

}  // namespace skyquilt::flight
