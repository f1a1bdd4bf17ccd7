// BandExpression: arithmetic over the bands of a map, such as (nir - red) / (nir + red), as users write it in
// an address: + - * / ** (or ^), unary minus, parentheses, numbers, names of bands, and sqrt, abs, log, exp,
// min, max, pow. Parsed once into a postfix program, then evaluated row by row.
//
// Precedence is that of Python: -a**2 is -(a**2), a**b**c is a**(b**c). Names are case-insensitive. A blank
// between two operands is a plus, because that is what a plus in an address is decoded to.
//
// Numbers are doubles, as numpy computes them, except that what has no finite value (a division by zero, the
// root of a negative number, the logarithm of zero) is NaN at once, and whatever is made of NaN is NaN.
//
// Bounded: kMaxLength characters, kMaxDepth levels of nesting, kMaxNodes operations and operands, of these
// kMaxCurves of the slow ones (exp, log, pow). Longer text is refused before it is looked at. Immutable; any
// thread. Errors: kInvalidArgument; the message names the place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::indices {

class BandExpression {
 public:
  static constexpr std::size_t kMaxLength = 512;
  static constexpr int kMaxDepth = 32;
  static constexpr std::size_t kMaxNodes = 128;
  static constexpr int kMaxCurves = 8;
  static constexpr std::size_t kMaxNameLength = 32;

  static Result<BandExpression> Parse(std::string_view text);

  // What it reads, in lower case, each once, in order of appearance.
  const std::vector<std::string>& bands() const { return bands_; }

  // `values`: as many rows as bands(), in their order, each as long as `out`; NaN where nothing is known.
  void Evaluate(std::span<const float* const> values, std::span<float> out) const;
  void Evaluate(std::span<const double* const> values, std::span<float> out) const;

 private:
  friend class ExpressionParser;
  enum class Operation : std::uint8_t {
    kNumber,
    kBand,
    kNegate,
    kAdd,
    kSubtract,
    kMultiply,
    kDivide,
    kPower,
    kSqrt,
    kAbs,
    kLog,
    kExp,
    kMin,
    kMax
  };
  struct Step {
    Operation operation = Operation::kNumber;
    double number = 0.0;   // of kNumber
    std::size_t band = 0;  // of kBand: place in bands_
  };
  template <typename Value>
  void EvaluateRows(std::span<const Value* const> values, std::span<float> out) const;
  // Into the first row of the stack.
  template <typename Value>
  void EvaluateChunk(std::span<const Value* const> values, std::size_t first, std::size_t count,
                     std::vector<double>& stack) const;

  std::vector<std::string> bands_;
  std::vector<Step> steps_;  // postfix
  std::size_t stack_depth_ = 0;
};

}  // namespace skyquilt::indices
