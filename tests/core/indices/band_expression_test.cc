// Expressions over bands: what they come to, against figures by hand and against a tree that is evaluated
// directly; and what is refused, with the place.
#include "core/indices/band_expression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace skyquilt::indices {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// With a = 2, b = 3, c = -1, zero = 0, unknown = NaN.
float Value(const std::string& text) {
  const Result<BandExpression> expression = BandExpression::Parse(text);
  EXPECT_TRUE(expression) << text << ": " << expression.error().message;
  if (!expression) return kNan;
  std::vector<float> bands;
  for (const std::string& name : expression->bands())
    bands.push_back(name == "a"      ? 2.0f
                    : name == "b"    ? 3.0f
                    : name == "c"    ? -1.0f
                    : name == "zero" ? 0.0f
                                     : kNan);
  std::vector<const float*> rows;
  for (const float& band : bands) rows.push_back(&band);
  float out = 0.0f;
  expression->Evaluate(rows, {&out, 1});
  return out;
}

std::string Refusal(const std::string& text) {
  const Result<BandExpression> expression = BandExpression::Parse(text);
  EXPECT_FALSE(expression) << text;
  if (expression) return "";
  EXPECT_EQ(expression.error().code, ErrorCode::kInvalidArgument);
  return expression.error().message;
}

std::string Times(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

TEST(BandExpressionTest, HasThePrecedenceOfPython) {
  EXPECT_FLOAT_EQ(Value("a+b*a"), 8);
  EXPECT_FLOAT_EQ(Value("(a+b)*a"), 10);
  EXPECT_FLOAT_EQ(Value("a-b-a"), -3);
  EXPECT_FLOAT_EQ(Value("b/a/a"), 0.75);
  EXPECT_FLOAT_EQ(Value("-a**2"), -4);
  EXPECT_FLOAT_EQ(Value("(-a)**2"), 4);
  EXPECT_FLOAT_EQ(Value("a**b**2"), 512);
  EXPECT_FLOAT_EQ(Value("a^-1"), 0.5);
  EXPECT_FLOAT_EQ(Value("2*-b"), -6);
  EXPECT_FLOAT_EQ(Value("--a"), 2);
  EXPECT_FLOAT_EQ(Value("+a - -b"), 5);
}

TEST(BandExpressionTest, ReadsNumbersNamesAndFunctions) {
  EXPECT_FLOAT_EQ(Value("1.5*(B - A)/(B + A + .5)"), 1.5f / 5.5f);
  EXPECT_FLOAT_EQ(Value("1e-1*a"), 0.2f);
  EXPECT_FLOAT_EQ(Value("sqrt(a*8)"), 4);
  EXPECT_FLOAT_EQ(Value("abs(c)"), 1);
  EXPECT_FLOAT_EQ(Value("log(exp(a))"), 2);
  EXPECT_FLOAT_EQ(Value("min(a, b) + max(a, b)"), 5);
  EXPECT_FLOAT_EQ(Value("pow(a, b)"), 8);
  EXPECT_EQ(BandExpression::Parse("(NIR-red)/(nir+Red)")->bands(), (std::vector<std::string>{"nir", "red"}));
}

TEST(BandExpressionTest, TakesABlankBetweenOperandsForThePlusThatItWas) {
  EXPECT_FLOAT_EQ(Value("(b-a)/(b a)"), 0.2f);
  EXPECT_FLOAT_EQ(Value("a   b*a"), 8);
  EXPECT_FLOAT_EQ(Value("(a) (b)"), 5);
  EXPECT_FLOAT_EQ(Value(" a "), 2);
}

TEST(BandExpressionTest, HasNoValueWhereNumbersHaveNone) {
  for (const char* text : {"a/zero", "zero/zero", "1/(1/zero)", "sqrt(c)", "log(zero)", "log(c)", "c**0.5",
                           "unknown", "unknown*0", "min(a, unknown)", "max(unknown, a)", "unknown**0",
                           "pow(1, unknown)", "exp(a*1000)", "a*1e300*1e300", "a*1e60"})
    EXPECT_TRUE(std::isnan(Value(text))) << text;
}

TEST(BandExpressionTest, SaysWhereItCannotGoOn) {
  const std::vector<std::pair<std::string, std::string>> kRefused = {
      {"", "character 1"},
      {"   ", "character 4"},
      {"nir-", "character 5"},
      {"(nir-red", "character 1"},
      {"nir-red)", "character 8"},
      {"nir*/red", "character 5"},
      {"nir $ red", "character 5"},
      {"2nir", "character 1"},
      {"1.2.3*a", "character 1"},
      {".", "character 1"},
      {"1e999*a", "character 1"},
      {"a**", "character 4"},
      {"sin(a)", "no function \"sin\""},
      {"a(b)", "a product needs its *"},
      {"min(a)", "two values"},
      {"min(a,b,c)", "closing parenthesis"},
      {"sqrt()", "character 6"},
      {"1+2", "names no band"},
      {"a,b", "character 2"},
      {"a\nb", "character 2"},
      {"__import__('os')", "character 1"},
      {"\xC3\xA4", "character 1"},
      {std::string(1, '\0'), "character 1"},
      {"inf*a", ""},  // a band of that name, if there is one
  };
  for (const auto& [text, place] : kRefused) {
    if (text == "inf*a") {
      EXPECT_EQ(BandExpression::Parse(text)->bands().front(), "inf");
      continue;
    }
    const std::string refusal = Refusal(text);
    EXPECT_NE(refusal.find(place), std::string::npos) << text << ": " << refusal;
  }
}

TEST(BandExpressionTest, IsBounded) {
  EXPECT_NE(Refusal(std::string(513, 'a')).find("513 characters"), std::string::npos);
  EXPECT_NE(Refusal(std::string(100, 'a')).find("long a name"), std::string::npos);
  EXPECT_NE(Refusal(Times("(", 255) + "a" + Times(")", 255)).find("nested"), std::string::npos);
  EXPECT_NE(Refusal(Times("-", 500) + "a").find("nested"), std::string::npos);
  EXPECT_NE(Refusal("a" + Times("**a", 100)).find("nested"), std::string::npos);
  EXPECT_NE(Refusal("a" + Times("+a", 200)).find("more than 128"), std::string::npos);
  EXPECT_NE(Refusal("a" + Times("+log(a)", 9)).find("more than 8"), std::string::npos);
  EXPECT_TRUE(BandExpression::Parse(Times("(", 31) + "a" + Times(")", 31)));
  EXPECT_TRUE(BandExpression::Parse("a" + Times("+a", 63)));
  EXPECT_TRUE(BandExpression::Parse("a" + Times("+log(a)", 8)));
}

// An expression as text and as what it is.
struct Tree {
  std::string text;
  double value = 0.0;
};

Tree RandomTree(std::mt19937& random, int depth) {
  const std::vector<Tree> kLeaves = {{"a", 2.0},    {"b", 3.0},   {"c", -1.0},
                                     {"zero", 0.0}, {"0.5", 0.5}, {"7", 7.0}};
  if (depth == 0 || random() % 5 == 0) return kLeaves[random() % kLeaves.size()];
  const Tree left = RandomTree(random, depth - 1), right = RandomTree(random, depth - 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const bool is_known = !std::isnan(left.value) && !std::isnan(right.value);
  switch (random() % 8) {
    case 0:
      return {"(" + left.text + "+" + right.text + ")", left.value + right.value};
    case 1:
      return {"(" + left.text + " - " + right.text + ")", left.value - right.value};
    case 2:
      return {left.text + "*" + right.text, left.value * right.value};
    case 3:
      return {"(" + left.text + "/(" + right.text + "))", right.value == 0 ? nan : left.value / right.value};
    case 4:
      return {"min(" + left.text + "," + right.text + ")",
              is_known ? std::fmin(left.value, right.value) : nan};
    case 5:
      return {"max( " + left.text + " ," + right.text + ")",
              is_known ? std::fmax(left.value, right.value) : nan};
    case 6:
      return {"sqrt(" + left.text + ")", left.value < 0 ? nan : std::sqrt(left.value)};
    default:
      return {"abs(" + left.text + ")", std::abs(left.value)};
  }
}

TEST(BandExpressionTest, EqualsATreeThatIsEvaluatedDirectly) {
  std::mt19937 random(7);
  int compared = 0;
  for (int i = 0; i < 3000; ++i) {
    const Tree tree = RandomTree(random, 4);
    const Result<BandExpression> expression = BandExpression::Parse("a*0+(" + tree.text + ")");
    if (!expression) {  // too long: the only way in which these are wrong
      EXPECT_TRUE(expression.error().message.find("more than") != std::string::npos ||
                  expression.error().message.find("characters") != std::string::npos)
          << tree.text << ": " << expression.error().message;
      continue;
    }
    ++compared;
    const float value = Value("a*0+(" + tree.text + ")");
    if (std::isfinite(tree.value)) {
      EXPECT_FLOAT_EQ(value, static_cast<float>(tree.value)) << tree.text;
    } else {
      EXPECT_TRUE(std::isnan(value)) << tree.text;
    }
  }
  EXPECT_GT(compared, 2000);
}

TEST(BandExpressionTest, EvaluatesRowsOfAnyLength) {
  const BandExpression ndvi = *BandExpression::Parse("(nir-red)/(nir+red)");
  for (const std::size_t count :
       {std::size_t{0}, std::size_t{1}, std::size_t{255}, std::size_t{257}, std::size_t{5000}}) {
    std::vector<float> nir(count), red(count), out(count);
    for (std::size_t i = 0; i < count; ++i) {
      nir[i] = static_cast<float>(i % 97) / 97.0f;
      red[i] = static_cast<float>(i % 13) / 13.0f;
    }
    ndvi.Evaluate(std::vector<const float*>{nir.data(), red.data()}, out);
    for (std::size_t i = 0; i < count; ++i) {
      const double sum = double(nir[i]) + red[i];
      if (sum == 0.0) {
        EXPECT_TRUE(std::isnan(out[i]));
      } else {
        EXPECT_FLOAT_EQ(out[i], static_cast<float>((double(nir[i]) - red[i]) / sum));
      }
    }
  }
}

}  // namespace
}  // namespace skyquilt::indices
