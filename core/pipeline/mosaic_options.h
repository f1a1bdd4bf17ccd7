// MosaicOptions: everything a user can choose about a map. Plain values with defaults; Validate names the
// field, the value and the rule. JobOption tells what clients call those that a job has. Values; any thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/geo/boundary.h"
#include "core/geo/lat_lon.h"
#include "core/image/picture_format.h"
#include "core/pipeline/placing/place_request.h"
#include "core/render/map_layer.h"

namespace skyquilt::pipeline {

// By numbers that maps made before know them by (DigestOfPlacing).
enum class AlignMethod { kAuto = 0, kImu = 1, kImages = 4 };

// What photos are laid on: the ground alone, on which houses and trees lean, or heights of every cell; or
// whichever the flight asks for (surface/choose_ground.h).
enum class MapGround { kSmooth, kDense, kAuto };

// Which heights are written beside the map: none, of all that stands there (DSM), or the ground's too (DTM).
enum class MapHeights { kNone, kSurface, kGround };

// As users write them.
inline constexpr std::pair<const char*, AlignMethod> kAlignMethods[] = {
    {"auto", AlignMethod::kAuto}, {"images", AlignMethod::kImages}, {"imu", AlignMethod::kImu}};
inline constexpr std::pair<const char*, MapGround> kMapGrounds[] = {
    {"smooth", MapGround::kSmooth}, {"dense", MapGround::kDense}, {"auto", MapGround::kAuto}};
const char* NameOf(MapGround ground);
inline constexpr std::pair<const char*, MapHeights> kMapHeights[] = {
    {"none", MapHeights::kNone}, {"dsm", MapHeights::kSurface}, {"dtm", MapHeights::kGround}};
inline constexpr std::pair<const char*, image::TileEncoding> kTileFormats[] = {
    {"auto", image::TileEncoding::kJpegWebp},
    {"jpeg-png", image::TileEncoding::kJpegPng},
    {"webp", image::TileEncoding::kWebp}};

struct MosaicOptions {
  AlignMethod method = AlignMethod::kAuto;  // --method
  std::optional<double> gsd_m;         // --gsd: ground size of an output pixel; default: that of the photos
  bool any_gsd = false;                // --any-gsd: also one far from what the photos show
  bool not_finer_than_photos = false;  // gsd_m counts only where it is coarser than the photos
  std::optional<double>
      readout_s;               // --readout-ms: of the cameras, first row to last; default: as known of them
  double max_look_deg = 65.0;  // --max-look-deg: off the vertical; nothing is drawn that a photo sees beyond
  std::optional<geo::LatLon> origin;  // --origin: where a flight without any position starts
  bool landed_at_start = false;       // --landed-at-start: a flight without any position ended where it began
  MapGround surface = MapGround::kSmooth;  // --surface
  MapHeights heights = MapHeights::kNone;  // --formats dsm, dtm. BuildMosaic writes none
  bool write_utm = false;                  // --formats utm. BuildMosaic writes none
  std::string dem_path;                    // --dem: a GeoTIFF of the ground's heights; empty: flat ground
  image::TileEncoding encoding = image::TileEncoding::kJpegWebp;  // --format
  int jpeg_quality = 85;                                          // --quality 1..100
  std::int64_t max_memory_bytes = std::int64_t{1} << 30;  // --max-memory: budget for decoded photos and tiles
  int threads = 0;                                        // --threads: 0 = all cores
  std::vector<render::MapLayer> layers;                   // --layers: tilesets of their own beside the map
  // `skyquilt place`: the finished map of the same files is brought to where the user says it lies.
  std::optional<PlaceRequest> placing;
  std::optional<geo::Boundary> boundary;  // --boundary: the map is cut to it; photos are placed as without
  std::optional<double> takeoff_height_amsl_m;  // --takeoff-height-m: of the take-off place
  std::string title;                            // name written into the tileset
  // Of the flight's files: a finished map of others, which becomes the map as it is (server/imports). Empty:
  // the map is made of photos. BuildMosaic knows nothing of it.
  std::string import_file;

  Result<void> Validate() const;
  // Whether gsd_m is a mistake (5 for 5 cm) beside what the photos show. Error: kInvalidArgument, with both
  // and how to insist.
  Result<void> CheckGsd(double photos_gsd_m) const;
  // What decides where photos lie and how the map is written, by the options of the command line, to tell two
  // runs apart. Without gsd_m and boundary, which are numbers that the map knows.
  std::map<std::string, std::string> InWords() const;
  // The way back, for the options that are `taken` by name. What says nothing here stays, and the elevation
  // model, of which the words have no path.
  void TakeWords(const std::map<std::string, std::string>& words,
                 const std::function<bool(const std::string&)>& taken);
  // The ground size of an output pixel where those of the photos show `photos_gsd_m`.
  double OutputGsdM(double photos_gsd_m) const;
};

enum class JobOptionKind { kNumber, kWhole, kYesNo, kChoice, kOther };

// An option of a job: what clients call it, its type, range, unit and choices, what it is good for, and where
// it stands in MosaicOptions. Command line, JSON, checks and contract read the table of them. Those whose
// values are places, areas and lists stand in it by name alone, and are read where their form is known.
struct JobOption {
  const char* name = "";  // in JSON; on the command line with dashes
  JobOptionKind kind = JobOptionKind::kOther;
  const char* unit = "";           // of a number, after its range
  double least = 0.0, most = 0.0;  // of a number
  bool may_be_open = false;        // null in JSON: as the photos have it
  bool decides_of_map = false;     // two maps that differ in it are two maps (MosaicOptions::InWords)
  std::span<const char* const> choices = {};
  const char* help = "";
  // A number as clients write it, the place of a choice among them, 1 for yes; nothing where it is open.
  std::optional<double> (*get)(const MosaicOptions& options) = nullptr;
  void (*set)(double value, MosaicOptions* options) = nullptr;

  std::string Flag() const;  // --max-look-deg
  // What a value must be, for messages: "must be a number between 10 and 75 degrees off the vertical".
  std::string Rule() const;
  bool Takes(double value) const { return value >= least && value <= most; }
};

std::span<const JobOption> JobOptionTable();
const JobOption* FindJobOption(std::string_view name);  // null: there is none

}  // namespace skyquilt::pipeline
