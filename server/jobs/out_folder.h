// CheckOutFolder: whether the map of these files can be written to a folder without destroying anything. A
// finished map of other photos, made with other options or with lists and logs that are not among the files
// is not replaced, nor is a file that merely has the name of one of our products. Accepted are an empty
// folder, what a killed run left, and a map all of whose photos are among the files (it is rebuilt, or
// grows). Reads the files' bytes when there is a map. Errors: kConflict, with what to do.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/process/file_descriptor.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/pipeline/mosaic_options.h"

namespace skyquilt::server {

Result<void> CheckOutFolder(const std::filesystem::path& out_dir, const std::vector<flight::InputFile>& files,
                            const pipeline::MosaicOptions& options);

// Whether a file below `root`, which is walked, is part of a map that was made there: a product beside its
// mosaic.state (a geo.txt that somebody put there is none), or a frame of a film, unless the root is the
// folder of frames. Such would pass for photos, positions and heights of the flight.
bool IsOfMap(const std::filesystem::path& file, const std::filesystem::path& root);

// What is given of a flight, without what in its folders IsOfMap. A file that is given by itself counts. Says
// on stderr that there were such, or folders that may not be read. Errors: kNotFound, kIo.
Result<std::vector<flight::InputFile>> FilesOfFlight(const std::vector<std::filesystem::path>& inputs);

// A folder in which a map is made, for as long as what is returned lives: of two runs at once one would
// publish what the other has half written. Nothing is held where there is no folder yet, or its disk knows no
// locks. Errors: kConflict (another run has it).
Result<FileDescriptor> TakeOutFolder(const std::filesystem::path& out_dir);

// Even where the user said to overwrite: no file that the map is to be made from. Errors: kConflict.
Result<void> CheckNoInputIsReplaced(const std::filesystem::path& out_dir,
                                    const std::vector<flight::InputFile>& files);

// That the photos and films of the finished map are what lies in their places still, which are among `files`:
// a card that was emptied has other photos of the same names. Errors: kConflict.
Result<void> CheckPhotosStay(const std::filesystem::path& out_dir,
                             const std::vector<flight::InputFile>& files);

// That no geo.txt but the map's own lies where that is written. Errors: kConflict.
Result<void> CheckListStays(const std::filesystem::path& out_dir);

// Which heights the folder's map has, so that they are written again with it. They show by dsm_photos.tif and
// dtm_ground.tif: a dsm.tif alone may be somebody's elevation model.
pipeline::MapHeights HeightsIn(const std::filesystem::path& out_dir);

}  // namespace skyquilt::server
