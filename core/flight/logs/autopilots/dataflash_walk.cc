#include "core/flight/logs/autopilots/dataflash_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skyquilt::flight {
namespace {

std::size_t SizeOfCode(char code) {
  switch (code) {
    case 'b':
    case 'B':
    case 'M':
      return 1;
    case 'h':
    case 'H':
    case 'c':
    case 'C':
    case 'g':
      return 2;
    case 'i':
    case 'I':
    case 'e':
    case 'E':
    case 'f':
    case 'L':
    case 'n':
      return 4;
    case 'q':
    case 'Q':
    case 'd':
      return 8;
    case 'N':
      return 16;
    case 'Z':
    case 'a':
      return 64;
    default:
      return 0;
  }
}

bool IsNumber(char code) { return code != 'n' && code != 'N' && code != 'Z' && code != 'a'; }

std::string_view FixedText(const std::uint8_t* from, std::size_t most) {
  std::size_t size = 0;
  while (size < most && from[size] != 0) ++size;
  return {reinterpret_cast<const char*>(from), size};
}

double HalfFloat(std::uint16_t bits) {
  const int exponent = bits >> 10 & 31;
  const double fraction = bits & 1023;
  const double sign = bits >> 15 ? -1.0 : 1.0;
  if (exponent == 31) return std::numeric_limits<double>::quiet_NaN();
  if (exponent == 0) return sign * std::ldexp(fraction, -24);
  return sign * std::ldexp(1024.0 + fraction, exponent - 25);
}

}  // namespace

const DataflashField* DataflashLayout::Find(std::initializer_list<std::string_view> names) const {
  for (const std::string_view wanted : names) {
    for (const DataflashField& field : fields) {
      if (field.name == wanted && IsNumber(field.code)) return &field;
    }
  }
  return nullptr;
}

double DataflashNumber(const DataflashField& field, const std::uint8_t* payload) {
  const std::uint8_t* from = payload + field.offset;
  switch (field.code) {
    case 'b':
      return LoadLittle<std::int8_t>(from);
    case 'B':
    case 'M':
      return *from;
    case 'h':
      return LoadLittle<std::int16_t>(from);
    case 'H':
      return LoadLittle<std::uint16_t>(from);
    case 'c':
      return LoadLittle<std::int16_t>(from) * 0.01;
    case 'C':
      return LoadLittle<std::uint16_t>(from) * 0.01;
    case 'g':
      return HalfFloat(LoadLittle<std::uint16_t>(from));
    case 'i':
      return LoadLittle<std::int32_t>(from);
    case 'I':
      return LoadLittle<std::uint32_t>(from);
    case 'e':
      return LoadLittle<std::int32_t>(from) * 0.01;
    case 'E':
      return LoadLittle<std::uint32_t>(from) * 0.01;
    case 'L':
      return LoadLittle<std::int32_t>(from) * 1e-7;
    case 'f':
      return LoadLittle<float>(from);
    case 'd':
      return LoadLittle<double>(from);
    case 'q':
      return static_cast<double>(LoadLittle<std::int64_t>(from));
    case 'Q':
      return static_cast<double>(LoadLittle<std::uint64_t>(from));
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
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
    if (SizeOfCode(code) == 0) {
      offset = 256;  // an unknown code: nothing behind it can be placed
      break;
    }
    layout.fields.push_back({std::string(labels.substr(0, comma)), code, offset});
    labels.remove_prefix(std::min(labels.size(), comma + 1));
    offset += SizeOfCode(code);
  }
  std::erase_if(layout.fields, [&](const DataflashField& field) {
    return field.offset + SizeOfCode(field.code) + 3 > layout.length;
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

}  // namespace skyquilt::flight
