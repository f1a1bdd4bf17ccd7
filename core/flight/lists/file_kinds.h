// Elevation models and films, told by content. Any thread, one source each.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// A map of heights rather than a picture: a GeoTIFF (a TIFF that says where on Earth it lies) with one band
// of floating-point or signed whole numbers. Pictures have three bands or more, thermal ones unsigned numbers
// and no such place. Reads the directory alone.
bool IsElevationModel(ByteSource& source);

// A TIFF file whose chain of directories is longer than any raster's with its overviews, or closes on itself,
// would be followed to its end by the library that opens it. Error: kUnsupportedFormat.
Result<void> CheckTiffDirectories(const std::filesystem::path& path);

// Of these files, by name.
std::vector<InputFile> ElevationModelsAmong(const std::vector<InputFile>& files);

// A film in an MP4 or MOV, by its first bytes (ISO/IEC 14496-12, the file type box); pictures in the same
// container (HEIC, AVIF, CR3) are none.
inline constexpr std::size_t kFilmHeadBytes = 12;
bool LooksLikeFilm(std::string_view head);

// Takes out what cameras write as small copies beside their films (.LRF, .LRV) where a film is left, and says
// so; nothing where there are none, or nothing else.
std::optional<Remark> LeaveOutFilmPreviews(std::vector<InputFile>& films);

}  // namespace skyquilt::flight
