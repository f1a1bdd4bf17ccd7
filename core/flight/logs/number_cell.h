// Numbers as people and programs write them in the cells of lists: decimal commas, marks of thousands,
// quotes, units behind the number. Pure functions; any thread. Nothing for what cannot be read or could be
// read in two ways; cells of more than 64 bytes are none.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace skyquilt::flight {

// Bytes of the blank or of the minus that `text` begins with, of any width; 0: of none.
std::size_t LengthOfBlank(std::string_view text);
std::size_t LengthOfMinus(std::string_view text);
// Without quotation marks around it and without a spreadsheet's apostrophe before it.
std::string_view BareCell(std::string_view cell);

// How a column writes its decimals, so that "1,234" and "1.234" have one meaning.
enum class DecimalMark {
  kUnknown,  // a lone mark is taken for a decimal one
  kPoint,
  kComma,
  kUnclear,  // a lone mark before three digits is not read
};

// What one cell says about it: kLonePoint and kLoneComma are "1.234" and "1,234".
enum class MarkEvidence { kNone, kPoint, kComma, kLonePoint, kLoneComma };
MarkEvidence EvidenceOfMark(std::string_view cell);

struct NumberCell {
  double value = 0.0;
  std::string_view unit;  // what stands behind the number, trimmed: "ft", "m Above Sea Level"
};

// "1234.5", "1234,5", "1,234.5", "1.234,5", "1 234,5", "1'234.5", "\"198.3\"", "650.62 ft", "198.3m".
std::optional<NumberCell> ReadNumber(std::string_view cell, DecimalMark mark = DecimalMark::kUnknown);

// The same as one value, where nothing stands behind it.
std::optional<double> ReadBareNumber(std::string_view cell);
// The same as one value: lengths in metres where a unit of length stands behind, degree signs dropped.
// Nothing where anything else stands behind the number.
std::optional<double> ReadNumberCell(std::string_view cell);

}  // namespace skyquilt::flight
