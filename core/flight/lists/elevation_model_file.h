// IsElevationModel: whether a file is a map of heights rather than a picture: a GeoTIFF (a TIFF that says
// where on Earth it lies) with one band of floating-point or signed whole numbers. Pictures have three bands
// or more, thermal ones unsigned numbers and no such place. Reads the directory alone. Any thread, one source
// each.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/input_file.h"

namespace skyquilt::flight {

bool IsElevationModel(ByteSource& source);

// A TIFF file whose chain of directories is longer than any raster's with its overviews, or closes on itself,
// would be followed to its end by the library that opens it. Error: kUnsupportedFormat.
Result<void> CheckTiffDirectories(const std::filesystem::path& path);

// Of these files, by name.
std::vector<InputFile> ElevationModelsAmong(const std::vector<InputFile>& files);

}  // namespace skyquilt::flight
