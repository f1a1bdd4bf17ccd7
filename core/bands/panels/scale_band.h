// ScaleBand: the factor by which the values of a band become reflectance, where several witnesses (pictures
// of a panel, targets on the ground) each say one: their median counts, and a warning tells where they are
// more than a tenth apart. Pure; any thread. Precondition: at least one factor, all above 0.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/bands/captures.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::bands {

// Multiplies all values of the band in `captures`; `by`: what the witnesses are, `method`: the same in words,
// for the band's. A warning where they are apart goes to `warnings`. The factor.
double ScaleBand(Captures& captures, const std::string& band, std::vector<double> factors, HeldAgainst by,
                 const std::string& method, std::vector<flight::Remark>& warnings);

// What a list says of a band; nothing where it says nothing.
std::optional<double> ReflectanceOf(const flight::KnownReflectance& known, const std::string& band);

}  // namespace skyquilt::bands
