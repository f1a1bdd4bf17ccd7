// IsElevationModel: whether a file is a map of heights rather than a picture: a GeoTIFF (a TIFF that says
// where on Earth it lies) with one band of floating-point or signed whole numbers. Pictures have three bands
// or more, thermal ones unsigned numbers and no such place. Reads the directory alone. Any thread, one source
// each.
#pragma once

#include <vector>

#include "core/flight/byte_source.h"
#include "core/flight/input_file.h"

namespace skyquilt::flight {

bool IsElevationModel(ByteSource& source);

// Of these files, by name.
std::vector<InputFile> ElevationModelsAmong(const std::vector<InputFile>& files);

}  // namespace skyquilt::flight
