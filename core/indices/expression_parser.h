// ExpressionParser: recursive descent over one expression, into the postfix program of a BandExpression. Used
// by BandExpression::Parse alone; one thread, once.
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/indices/band_expression.h"

namespace skyquilt::indices {

class ExpressionParser {
 public:
  // Precondition: `text` has at most BandExpression::kMaxLength characters.
  explicit ExpressionParser(std::string_view text) : text_(text) {}
  Result<BandExpression> Parse();

 private:
  using Operation = BandExpression::Operation;
  class Level;

  Result<void> Sum();
  Result<void> Product();
  Result<void> Signed();
  Result<void> Power();
  Result<void> Primary();
  Result<void> Number();
  Result<void> Name();
  Result<void> Call(const std::string& name, std::size_t at);

  void SkipBlanks();
  bool Take(char sign);
  bool TakePowerSign();
  bool BeginsOperand() const;
  Result<void> Emit(Operation operation, double number = 0.0, std::size_t band = 0);
  Error At(std::size_t place, const std::string& what) const;

  std::string_view text_;
  std::size_t next_ = 0;
  int depth_ = 0;
  int curves_ = 0;
  std::size_t stack_ = 0;  // values on it after the steps so far
  BandExpression made_;
};

}  // namespace skyquilt::indices
