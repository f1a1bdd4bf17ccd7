// Media types that more than one room names. Values.
#pragma once

namespace skyquilt::api {

inline constexpr const char* kCogType = "image/tiff; application=geotiff; profile=cloud-optimized";

}  // namespace skyquilt::api
