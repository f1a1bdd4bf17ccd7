// The grammar of BandExpression.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/try.h"
#include "core/indices/band_expression.h"

namespace skyquilt::indices {
namespace {

constexpr const char* kExample = "Write it like (nir-red)/(nir+red).";

bool IsBlank(char c) { return c == ' ' || c == '\t'; }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }
char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
bool IsNameStart(char c) { return Lower(c) >= 'a' && Lower(c) <= 'z'; }
bool IsNamePart(char c) { return IsNameStart(c) || IsDigit(c) || c == '_'; }

}  // namespace

// Recursive descent over one expression, into the postfix program of a BandExpression. One thread, once.
class ExpressionParser {
 public:
  // Precondition: `text` has at most BandExpression::kMaxLength characters.
  explicit ExpressionParser(std::string_view text) : text_(text) {}

  Result<BandExpression> Parse() {
    SKYQUILT_TRY(Sum());
    SkipBlanks();
    if (next_ < text_.size())
      return At(next_, text_[next_] == ')' ? "this parenthesis closes none"
                                           : "an operator (+ - * / **) or the end is expected here");
    if (made_.bands_.empty())
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("The expression names no band, so it is the same everywhere. {}", kExample),
                   ""};
    return std::move(made_);
  }

 private:
  using Operation = BandExpression::Operation;

  // One more level of nesting for as long as it lives.
  class Level {
   public:
    explicit Level(ExpressionParser& parser) : parser_(parser) { ++parser_.depth_; }
    ~Level() { --parser_.depth_; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;
    bool IsTooDeep() const { return parser_.depth_ > BandExpression::kMaxDepth; }

   private:
    ExpressionParser& parser_;
  };

  Error At(std::size_t place, const std::string& what) const {
    return {ErrorCode::kInvalidArgument,
            fmt::format("The expression cannot be read at character {}: {}. {}", place + 1, what, kExample),
            ""};
  }

  void SkipBlanks() {
    while (next_ < text_.size() && IsBlank(text_[next_])) ++next_;
  }

  bool Take(char sign) {
    SkipBlanks();
    if (next_ >= text_.size() || text_[next_] != sign) return false;
    ++next_;
    return true;
  }

  bool TakePowerSign() {
    if (Take('^')) return true;
    if (!text_.substr(next_).starts_with("**")) return false;
    next_ += 2;
    return true;
  }

  bool BeginsOperand() const {
    return next_ < text_.size() &&
           (IsNameStart(text_[next_]) || IsDigit(text_[next_]) || text_[next_] == '.' || text_[next_] == '(');
  }

  Result<void> Emit(Operation operation, double number = 0.0, std::size_t band = 0) {
    if (made_.steps_.size() >= BandExpression::kMaxNodes)
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("The expression has more than {} numbers, bands and signs. Write a shorter one.",
                      BandExpression::kMaxNodes),
          ""};
    const bool is_curve =
        operation == Operation::kPower || operation == Operation::kLog || operation == Operation::kExp;
    if (is_curve && ++curves_ > BandExpression::kMaxCurves)
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("The expression has more than {} powers, logarithms and exponentials, which take "
                      "long. Write a shorter one.",
                      BandExpression::kMaxCurves),
          ""};
    made_.steps_.push_back({operation, number, band});
    switch (operation) {
      case Operation::kNumber:
      case Operation::kBand:
        made_.stack_depth_ = std::max(made_.stack_depth_, ++stack_);
        break;
      case Operation::kNegate:
      case Operation::kSqrt:
      case Operation::kAbs:
      case Operation::kLog:
      case Operation::kExp:
        break;
      default:
        --stack_;
    }
    return {};
  }

  Result<void> Sum() {
    const Level level(*this);
    if (level.IsTooDeep())
      return At(next_, fmt::format("it is nested more than {} deep", BandExpression::kMaxDepth));
    SKYQUILT_TRY(Product());
    while (true) {
      const std::size_t end_of_operand = next_;
      if (Take('+')) {
        SKYQUILT_TRY(Product());
        SKYQUILT_TRY(Emit(Operation::kAdd));
      } else if (Take('-')) {
        SKYQUILT_TRY(Product());
        SKYQUILT_TRY(Emit(Operation::kSubtract));
      } else if (next_ > end_of_operand && BeginsOperand()) {  // a plus that was decoded to a blank
        SKYQUILT_TRY(Product());
        SKYQUILT_TRY(Emit(Operation::kAdd));
      } else {
        return {};
      }
    }
  }

  Result<void> Product() {
    SKYQUILT_TRY(Signed());
    while (true) {
      const std::size_t before_blanks = next_;
      if (Take('*')) {
        SKYQUILT_TRY(Signed());
        SKYQUILT_TRY(Emit(Operation::kMultiply));
      } else if (Take('/')) {
        SKYQUILT_TRY(Signed());
        SKYQUILT_TRY(Emit(Operation::kDivide));
      } else {
        next_ = before_blanks;
        return {};
      }
    }
  }

  Result<void> Signed() {
    const bool is_negative = Take('-');
    if (!is_negative && !Take('+')) return Power();
    const Level level(*this);
    if (level.IsTooDeep())
      return At(next_, fmt::format("it is nested more than {} deep", BandExpression::kMaxDepth));
    SKYQUILT_TRY(Signed());
    return is_negative ? Emit(Operation::kNegate) : Result<void>();
  }

  Result<void> Power() {
    SKYQUILT_TRY(Primary());
    const std::size_t before_blanks = next_;
    SkipBlanks();
    if (!TakePowerSign()) {
      next_ = before_blanks;
      return {};
    }
    const Level level(*this);
    if (level.IsTooDeep())
      return At(next_, fmt::format("it is nested more than {} deep", BandExpression::kMaxDepth));
    SKYQUILT_TRY(Signed());
    return Emit(Operation::kPower);
  }

  Result<void> Primary() {
    SkipBlanks();
    if (next_ >= text_.size()) return At(next_, "it ends where a band or a number is expected");
    const char c = text_[next_];
    if (IsDigit(c) || c == '.') return Number();
    if (IsNameStart(c)) return Name();
    if (c != '(') return At(next_, "a band, a number or a parenthesis is expected here");
    const std::size_t opened = next_;
    ++next_;
    SKYQUILT_TRY(Sum());
    return Take(')') ? Result<void>() : At(opened, "this parenthesis is not closed");
  }

  Result<void> Number() {
    double number = 0.0;
    const char* const first = text_.data() + next_;
    const auto parsed = std::from_chars(first, text_.data() + text_.size(), number);
    const std::size_t at = next_;
    if (parsed.ec != std::errc() || !std::isfinite(number)) return At(at, "this is no number of usual size");
    next_ += static_cast<std::size_t>(parsed.ptr - first);
    if (next_ < text_.size() && (IsNamePart(text_[next_]) || text_[next_] == '.'))
      return At(at, "a number is followed by a letter; a product needs its *");
    return Emit(Operation::kNumber, number);
  }

  Result<void> Name() {
    const std::size_t at = next_;
    std::string name;
    while (next_ < text_.size() && IsNamePart(text_[next_])) name += Lower(text_[next_++]);
    if (name.size() > BandExpression::kMaxNameLength) return At(at, "no band has so long a name");
    const std::size_t before_blanks = next_;
    if (Take('(')) return Call(name, at);
    next_ = before_blanks;
    const auto known = std::find(made_.bands_.begin(), made_.bands_.end(), name);
    const auto band = static_cast<std::size_t>(known - made_.bands_.begin());
    if (known == made_.bands_.end()) made_.bands_.push_back(name);
    return Emit(Operation::kBand, 0.0, band);
  }

  Result<void> Call(const std::string& name, std::size_t at) {
    struct Function {
      std::string_view name;
      Operation operation;
      int arguments;
    };
    static constexpr std::array kFunctions = {
        Function{"sqrt", Operation::kSqrt, 1}, Function{"abs", Operation::kAbs, 1},
        Function{"log", Operation::kLog, 1},   Function{"exp", Operation::kExp, 1},
        Function{"min", Operation::kMin, 2},   Function{"max", Operation::kMax, 2},
        Function{"pow", Operation::kPower, 2}};
    const auto* const function = std::find_if(kFunctions.begin(), kFunctions.end(),
                                              [&](const Function& known) { return known.name == name; });
    if (function == kFunctions.end())
      return At(at,
                fmt::format("there is no function \"{}\"; there are sqrt, abs, log, exp, min, max and pow, "
                            "and a product needs its *",
                            name));
    for (int argument = 0; argument < function->arguments; ++argument) {
      if (argument > 0 && !Take(','))
        return At(next_, fmt::format("{} takes two values with a comma between", name));
      SKYQUILT_TRY(Sum());
    }
    if (!Take(')'))
      return At(next_, fmt::format("{} takes {} and then a closing parenthesis", name,
                                   function->arguments == 1 ? "one value" : "two values"));
    return Emit(function->operation);
  }

  std::string_view text_;
  std::size_t next_ = 0;
  int depth_ = 0;
  int curves_ = 0;
  std::size_t stack_ = 0;  // values on it after the steps so far
  BandExpression made_;
};

Result<BandExpression> BandExpression::Parse(std::string_view text) {
  if (text.size() > kMaxLength)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("The expression has {} characters; the most are {}. Write a shorter one.",
                             text.size(), kMaxLength),
                 ""};
  return ExpressionParser(text).Parse();
}

}  // namespace skyquilt::indices
