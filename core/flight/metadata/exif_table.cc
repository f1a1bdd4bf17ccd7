#include "core/flight/metadata/exif_table.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {
namespace {

double Integer(const std::uint8_t* p, std::size_t size, bool is_big_endian, bool is_signed) {
  const std::uint64_t value = UnsignedAt(p, size, is_big_endian);
  if (!is_signed) return static_cast<double>(value);
  const unsigned shift = 64 - 8 * static_cast<unsigned>(size);
  return static_cast<double>(static_cast<std::int64_t>(value << shift) >> shift);
}

std::optional<double> Finite(double value) {
  if (!std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::size_t ExifTypeSize(std::uint16_t type) {
  switch (static_cast<ExifType>(type)) {
    case ExifType::kByte:
    case ExifType::kAscii:
    case ExifType::kSByte:
    case ExifType::kUndefined:
      return 1;
    case ExifType::kShort:
    case ExifType::kSShort:
      return 2;
    case ExifType::kLong:
    case ExifType::kSLong:
    case ExifType::kFloat:
    case ExifType::kIfd:
      return 4;
    case ExifType::kRational:
    case ExifType::kSRational:
    case ExifType::kDouble:
    case ExifType::kLong8:
    case ExifType::kSLong8:
    case ExifType::kIfd8:
      return 8;
  }
  return 0;
}

std::optional<ExifValue::Fraction> ExifValue::Rational(std::size_t i) const {
  const bool is_signed = type == static_cast<std::uint16_t>(ExifType::kSRational);
  if (!is_signed && type != static_cast<std::uint16_t>(ExifType::kRational)) return std::nullopt;
  if (i >= bytes.size() / 8) return std::nullopt;
  const std::uint8_t* p = bytes.data() + 8 * i;
  return Fraction{Integer(p, 4, is_big_endian, is_signed), Integer(p + 4, 4, is_big_endian, is_signed)};
}

std::optional<double> ExifValue::Number(std::size_t i) const {
  const std::size_t size = ExifTypeSize(type);
  if (size == 0 || i >= bytes.size() / size) return std::nullopt;
  const std::uint8_t* p = bytes.data() + size * i;
  switch (static_cast<ExifType>(type)) {
    case ExifType::kAscii:
    case ExifType::kUndefined:
      return std::nullopt;
    case ExifType::kRational:
    case ExifType::kSRational: {
      const auto fraction = Rational(i);
      if (!fraction || fraction->denominator == 0.0) return std::nullopt;
      return Finite(fraction->numerator / fraction->denominator);
    }
    case ExifType::kFloat:
      return Finite(std::bit_cast<float>(static_cast<std::uint32_t>(UnsignedAt(p, 4, is_big_endian))));
    case ExifType::kDouble:
      return Finite(std::bit_cast<double>(UnsignedAt(p, 8, is_big_endian)));
    case ExifType::kSByte:
    case ExifType::kSShort:
    case ExifType::kSLong:
    case ExifType::kSLong8:
      return Integer(p, size, is_big_endian, true);
    default:
      return Integer(p, size, is_big_endian, false);
  }
}

std::string ExifValue::Text() const {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    if (byte == 0) break;
    text.push_back(byte >= 0x20 && byte < 0x7F ? static_cast<char>(byte) : '?');
  }
  const auto first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

const ExifValue* ExifTable::Find(ExifIfd ifd, std::uint16_t tag) const {
  const auto it = values_.find({ifd, tag});
  return it == values_.end() ? nullptr : &it->second;
}

std::optional<double> ExifTable::Number(ExifIfd ifd, std::uint16_t tag, std::size_t i) const {
  const ExifValue* value = Find(ifd, tag);
  return value ? value->Number(i) : std::nullopt;
}

std::string ExifTable::Text(ExifIfd ifd, std::uint16_t tag) const {
  const ExifValue* value = Find(ifd, tag);
  return value ? value->Text() : std::string();
}

}  // namespace skyquilt::flight
