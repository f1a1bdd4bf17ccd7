#include "core/indices/spectral_index.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "core/base/check.h"
#include "core/indices/band_expression.h"

namespace skyquilt::indices {
namespace {

constexpr std::array kIndices = {
    // Rouse and others 1974, Monitoring vegetation systems in the Great Plains with ERTS.
    SpectralIndex{"ndvi", "NDVI", "(nir-red)/(nir+red)", 0.0, 1.0, "rdylgn"},
    // Gitelson and Merzlyak 1994, doi 10.1016/1011-1344(93)06963-4.
    SpectralIndex{"ndre", "NDRE", "(nir-rededge)/(nir+rededge)", 0.0, 0.6, "rdylgn"},
    // Gitelson and others 1996, doi 10.1016/S0034-4257(96)00072-7.
    SpectralIndex{"gndvi", "GNDVI", "(nir-green)/(nir+green)", 0.0, 1.0, "rdylgn"},
    // Huete 1988 with L = 0.5, doi 10.1016/0034-4257(88)90106-X.
    SpectralIndex{"savi", "SAVI", "1.5*(nir-red)/(nir+red+0.5)", 0.0, 1.0, "rdylgn"},
    // Gitelson and others 2002, doi 10.1016/S0034-4257(01)00289-9.
    SpectralIndex{"vari", "VARI", "(green-red)/(green+red-blue)", -0.4, 0.4, "rdylgn"},
    // Louhaichi and others 2001, doi 10.1080/10106040108542184.
    SpectralIndex{"gli", "GLI", "(2*green-red-blue)/(2*green+red+blue)", -0.2, 0.3, "rdylgn"},
    // Woebbecke and others 1995, doi 10.13031/2013.27838: of the shares of the colours.
    SpectralIndex{"exg", "ExG", "(2*green-red-blue)/(red+green+blue)", -0.2, 0.5, "rdylgn"},
    // Of thermal bands, which are in kelvin: degrees Celsius.
    SpectralIndex{"celsius", "Temperature", "lwir-273.15", 0.0, 50.0, "inferno"},
};

bool EqualsInLowerCase(std::string_view name, std::string_view text) {
  return name.size() == text.size() && std::equal(name.begin(), name.end(), text.begin(), [](char a, char b) {
           return a == std::tolower(static_cast<unsigned char>(b));
         });
}

}  // namespace

std::span<const SpectralIndex> AllIndices() { return kIndices; }

const SpectralIndex* FindIndex(std::string_view name) {
  const auto* const found = std::find_if(kIndices.begin(), kIndices.end(), [&](const SpectralIndex& index) {
    return EqualsInLowerCase(index.name, name);
  });
  return found == kIndices.end() ? nullptr : found;
}

std::vector<const SpectralIndex*> IndicesOf(const std::vector<std::string>& bands) {
  std::vector<const SpectralIndex*> possible;
  for (const SpectralIndex& index : kIndices) {
    const Result<BandExpression> expression = BandExpression::Parse(index.expression);
    SKYQUILT_CHECK(expression.ok(), "a formula of our own does not parse");
    const bool has_all = std::all_of(
        expression->bands().begin(), expression->bands().end(),
        [&](const std::string& band) { return std::find(bands.begin(), bands.end(), band) != bands.end(); });
    if (has_all) possible.push_back(&index);
  }
  return possible;
}

}  // namespace skyquilt::indices
