// An expression over bands, as anybody may write it in an address: bounded, and every value finite or none.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "core/base/check.h"
#include "core/indices/band_expression.h"
#include "core/indices/colour_ramp.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt::indices;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  (void)ColourRamp::Named(text);
  const auto expression = BandExpression::Parse(text);
  if (!expression) {
    SKYQUILT_CHECK(!expression.error().message.empty(), "a refusal without a word");
    return 0;
  }
  SKYQUILT_CHECK(!expression->bands().empty() && expression->bands().size() <= BandExpression::kMaxNodes,
                 "an expression of no bands or of too many");
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::array<float, 8> row = {0.0f,      1.0f,       -1.0f, std::numeric_limits<float>::quiet_NaN(),
                                    kInfinity, -kInfinity, 1e38f, 1e-38f};
  const std::vector<const float*> rows(expression->bands().size(), row.data());
  std::array<float, row.size()> out{};
  expression->Evaluate(rows, out);
  for (const float value : out)
    SKYQUILT_CHECK(std::isfinite(value) || std::isnan(value), "a value without end");
  return 0;
}
