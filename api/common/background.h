// What lies behind a map where it shows nothing: a colour, by its hexadecimal digits or its name in CSS, and
// laying pixels on one. Pure. Errors: kInvalidArgument.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/base/result.h"
#include "core/image/rgba_image.h"

namespace skyquilt::api {

using Rgb = std::array<std::uint8_t, 3>;
inline constexpr Rgb kWhite = {255, 255, 255};

// "0xFFCC00", "FFCC00", "#ffcc00", or one of the 148 names of CSS Color Module 4, in any case. `name`: of the
// parameter, for the message.
Result<Rgb> ParseColour(std::string_view text, std::string_view name);

// One pixel, opaque afterwards; straight alpha.
void LayOn(std::uint8_t* pixel, const Rgb& colour);
void LayOn(image::RgbaImage& pixels, const Rgb& colour);

}  // namespace skyquilt::api
