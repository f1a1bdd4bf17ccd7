#include "core/indices/band_expression.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/vector_clones.h"

namespace skyquilt::indices {
namespace {

constexpr std::size_t kChunk = 256;  // values evaluated at once: rows of them stay in the nearest cache
constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

double FiniteOrNan(double value) { return std::isfinite(value) ? value : kNoValue; }

SKYQUILT_VECTOR_CLONES void AddRows(double* a, const double* b, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) a[i] += b[i];
}
SKYQUILT_VECTOR_CLONES void SubtractRows(double* a, const double* b, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) a[i] -= b[i];
}
SKYQUILT_VECTOR_CLONES void MultiplyRows(double* a, const double* b, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) a[i] *= b[i];
}
SKYQUILT_VECTOR_CLONES void DivideRows(double* a, const double* b, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) a[i] = b[i] == 0.0 ? kNoValue : a[i] / b[i];
}

}  // namespace

void BandExpression::Evaluate(std::span<const float* const> values, std::span<float> out) const {
  EvaluateRows(values, out);
}
void BandExpression::Evaluate(std::span<const double* const> values, std::span<float> out) const {
  EvaluateRows(values, out);
}

template <typename Value>
void BandExpression::EvaluateRows(std::span<const Value* const> values, std::span<float> out) const {
  SKYQUILT_CHECK(values.size() == bands_.size(), "an expression was given another number of bands");
  std::vector<double> stack(stack_depth_ * kChunk);
  for (std::size_t first = 0; first < out.size(); first += kChunk) {
    const std::size_t count = std::min(kChunk, out.size() - first);
    EvaluateChunk(values, first, count, stack);
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = static_cast<float>(FiniteOrNan(stack[i]));
      out[first + i] = std::isfinite(value) ? value : std::numeric_limits<float>::quiet_NaN();
    }
  }
}

template <typename Value>
void BandExpression::EvaluateChunk(std::span<const Value* const> values, std::size_t first, std::size_t count,
                                   std::vector<double>& stack) const {
  std::size_t used = 0;  // rows of the stack
  for (const Step& step : steps_) {
    double* const above = stack.data() + used * kChunk;
    double* const top = used < 1 ? nullptr : above - kChunk;        // the one operand, or the second of two
    double* const below = used < 2 ? nullptr : above - 2 * kChunk;  // the first, which the result replaces
    const auto each = [&](double* row, auto&& of) {
      for (std::size_t i = 0; i < count; ++i) row[i] = of(i);
    };
    switch (step.operation) {
      case Operation::kNumber:
        std::fill_n(above, count, step.number);
        ++used;
        continue;
      case Operation::kBand:
        std::copy_n(values[step.band] + first, count, above);
        ++used;
        continue;
      case Operation::kNegate:
        each(top, [&](std::size_t i) { return -top[i]; });
        continue;
      case Operation::kSqrt:
        each(top, [&](std::size_t i) { return top[i] < 0.0 ? kNoValue : std::sqrt(top[i]); });
        continue;
      case Operation::kAbs:
        each(top, [&](std::size_t i) { return std::abs(top[i]); });
        continue;
      case Operation::kLog:
        each(top, [&](std::size_t i) { return top[i] > 0.0 ? std::log(top[i]) : kNoValue; });
        continue;
      case Operation::kExp:
        each(top, [&](std::size_t i) { return FiniteOrNan(std::exp(top[i])); });
        continue;
      case Operation::kAdd:
        AddRows(below, top, count);
        break;
      case Operation::kSubtract:
        SubtractRows(below, top, count);
        break;
      case Operation::kMultiply:
        MultiplyRows(below, top, count);
        break;
      case Operation::kDivide:
        DivideRows(below, top, count);
        break;
      case Operation::kPower:
        // pow(1, NaN) and pow(NaN, 0) are 1 by C's rules: what is not known stays so.
        each(below, [&](std::size_t i) {
          return std::isnan(below[i]) || std::isnan(top[i]) ? kNoValue
                                                            : FiniteOrNan(std::pow(below[i], top[i]));
        });
        break;
      case Operation::kMin:
        each(below, [&](std::size_t i) {
          return std::isnan(below[i]) || std::isnan(top[i]) ? kNoValue : std::min(below[i], top[i]);
        });
        break;
      case Operation::kMax:
        each(below, [&](std::size_t i) {
          return std::isnan(below[i]) || std::isnan(top[i]) ? kNoValue : std::max(below[i], top[i]);
        });
        break;
    }
    --used;
  }
}

}  // namespace skyquilt::indices
