#include "api/common/index_look.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <utility>

#include "api/http/links.h"
#include "api/http/parameters.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

constexpr const char* kUsualRamp = "rdylgn";

Error BadLook(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

std::string NamesOfIndices() {
  std::vector<std::string_view> names;
  for (const indices::SpectralIndex& index : indices::AllIndices()) names.push_back(index.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

Result<std::array<double, 2>> ParseRescale(std::string_view text) {
  const Error refused = BadLook(
      "The parameter \"rescale\" takes two numbers, the lesser first: the values of the ends of the colours, as "
      "in rescale=-0.2,0.9.");
  constexpr double kMaxEnd = 1e9;
  const std::optional<std::vector<double>> ends = FiniteNumbers(text, 2);
  if (!ends || ends->size() != 2) return refused;
  const double least = ends->front(), most = ends->back();
  if (least >= most || std::abs(least) >= kMaxEnd || std::abs(most) >= kMaxEnd) return refused;
  return std::array{least, most};
}

Result<IndexLook> LookNamed(std::string_view name) {
  const indices::SpectralIndex* const index = indices::FindIndex(name);
  if (index != nullptr) return LookOf(*index);
  return BadLook(
      fmt::format("There is no index of this name. There are {}; any other is asked for with \"expression\".",
                  NamesOfIndices()));
}

Result<IndexLook> LookOfExpression(std::string_view text) {
  SKYQUILT_TRY_ASSIGN(indices::BandExpression expression, indices::BandExpression::Parse(text));
  return IndexLook{"",
                   std::string(text),
                   std::string(text),
                   std::move(expression),
                   -1.0,
                   1.0,
                   kUsualRamp,
                   *indices::ColourRamp::Named(kUsualRamp)};
}

}  // namespace

std::string IndexLook::Query() const {
  return fmt::format("{}={}&rescale={},{}&colormap={}", name.empty() ? "expression" : "index",
                     EncodedForQuery(name.empty() ? text : name), least, most, ramp_name);
}

IndexLook LookOf(const indices::SpectralIndex& index) {
  // Tests parse every formula and find every ramp of the table.
  return IndexLook{std::string(index.name),
                   std::string(index.title),
                   std::string(index.expression),
                   *indices::BandExpression::Parse(index.expression),
                   index.least,
                   index.most,
                   std::string(index.ramp),
                   *indices::ColourRamp::Named(index.ramp)};
}

Result<std::optional<IndexLook>> LookIn(const Request& request) {
  const auto name = request.Query("index"), text = request.Query("expression");
  const auto rescale = request.Query("rescale");
  const auto ramp = request.Query("colormap") ? request.Query("colormap") : request.Query("colormap_name");
  if (!name && !text) {
    if (!rescale && !ramp) return std::optional<IndexLook>();
    return BadLook(
        "The parameters \"rescale\" and \"colormap\" colour an index: say which, as in index=ndvi or "
        "expression=(nir-red)/(nir%2Bred).");
  }
  if (name && text) return BadLook("Ask for an index by its name or by an expression, not by both.");
  SKYQUILT_TRY_ASSIGN(IndexLook look, name ? LookNamed(*name) : LookOfExpression(*text));
  if (rescale) {
    SKYQUILT_TRY_ASSIGN(const auto ends, ParseRescale(*rescale));
    look.least = ends[0];
    look.most = ends[1];
  }
  if (ramp) {
    const std::optional<indices::ColourRamp> found = indices::ColourRamp::Named(*ramp);
    if (!found)
      return BadLook(fmt::format(
          "There is no colormap of this name. There are {}; \"_r\" behind a name turns the colours round.",
          fmt::join(indices::ColourRamp::Names(), ", ")));
    look.ramp = *found;
    look.ramp_name = LowerCase(*ramp);
  }
  return std::optional(std::move(look));
}

Result<IndexLook> LookRequiredIn(const Request& request) {
  SKYQUILT_TRY_ASSIGN(std::optional<IndexLook> look, LookIn(request));
  if (look) return *std::move(look);
  return BadLook(
      fmt::format("Say which index is meant, as in index=ndvi or expression=(nir-red)/(nir%2Bred). "
                  "Those with a name are {}.",
                  NamesOfIndices()));
}

Result<std::optional<IndexLook>> LookOfStyle(std::string_view style) {
  if (style.empty() || style == "default") return std::optional<IndexLook>();
  const indices::SpectralIndex* const index = indices::FindIndex(style);
  if (index != nullptr) return std::optional(LookOf(*index));
  return BadLook(fmt::format(
      "There is no such style. Styles are default and, of a map that has the bands, {}.", NamesOfIndices()));
}

}  // namespace skyquilt::api
