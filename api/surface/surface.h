// Surface: which heights of a map: of what the photos show (dsm), or of the ground below (dtm). A value.
#pragma once

#include <cstdint>

namespace skyquilt::api {

enum class Surface : std::uint8_t { kPhotos, kGround };

}  // namespace skyquilt::api
