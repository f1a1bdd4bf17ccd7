// Temperatures of thermal pictures: from the levels of a TIFF that says how many kelvins a level is, and from
// those of a FLIR camera's radiometric JPEG by its Planck constants. Pure; any thread. Sources:
//   FLIR Systems 102-9012-01, Interface Requirements Specification for FLIR TIFF File Format, and the user
//     guides of Duo, Duo Pro R and Vue Pro R (TLinear: kelvins are level times gain, 0.4, 0.04 or 0.01);
//   MicaSense, Altum integration guide (levels of the LWIR band are hundredths of a kelvin);
//   FLIR Systems, ThermaCAM user manuals, "The measurement formula" and "transmission of the atmosphere".
#pragma once

#include <optional>
#include <string_view>

#include "core/bands/radiometry.h"
#include "core/flight/metadata/flir_record.h"
#include "core/flight/metadata/xmp.h"

namespace skyquilt::bands {

// Nothing where the tags do not say what a level is: guessing one would be wrong by a factor.
std::optional<Radiometry> LinearTemperature(std::string_view make, const flight::XmpTags& xmp);

// Nothing where the constants are none that a camera can have. Emissivity, reflected light, air and window
// are taken as the camera recorded them; what is out of all range counts as not there.
std::optional<Radiometry> FlirTemperature(const flight::FlirConstants& constants);

}  // namespace skyquilt::bands
