// FlightFacts: what a run remembers of its flight for the next one: where every photo was placed and how its
// light was evened out, the ground, and which photo shows what. From it a killed run goes on without
// comparing photos again, and photos added to a finished flight are placed against it while everything else
// stays. Kept in mosaic.state as CBOR (RFC 8949). A value; any thread. Errors of parsing: kCorrupt.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/aligned_flight.h"
#include "core/base/digest.h"
#include "core/flight/bytes/input_file.h"
#include "core/geo/boundary.h"
#include "core/ground/ground_surface.h"
#include "core/ground/model_ground_report.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/ground_choice.h"
#include "core/poses/pose_report.h"
#include "core/render/exposure/estimate_exposure.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_map.h"
#include "core/render/seams/seam_shift.h"
#include "core/render/thumbnail.h"

namespace skyquilt::pipeline {

struct NamedDigest {
  flight::InputFile file;
  Digest digest{};
};

// The appearance of the map, decided before it was rendered.
struct MapAppearance {
  double gsd_m = 0.0;
  render::KnownExposure exposure;  // a gain for each photo, and the light
  render::SeamGrid grid;
  render::SeamLabels labels;
  bool stands_upright = false;  // the labels know what hides what (MapSurface)
  bool is_gsd_asked = false;    // somebody said gsd_m; false: the photos' own
};

struct FlightFacts {
  Digest options{};                          // of what alignment was asked to do
  std::map<std::string, std::string> asked;  // MosaicOptions::InWords; none in maps of earlier versions
  std::vector<NamedDigest> inputs;           // all files, also those that are no photos
  // Without tie points. Photos hold their name, camera and lens, and the position that they were placed by
  // (a list's, say; in maps of earlier versions none does), without its source.
  alignment::AlignedFlight flight;
  ground::GroundSurface ground = ground::GroundSurface::Plane(0.0);
  std::vector<render::Thumbnail> thumbnails;  // one per photo
  std::string height_rule;
  bool is_placed = true;
  bool is_by_images = false;  // some photos were placed by what they show, against or without their records
  bool is_by_hand = false;    // somebody said where it lies; no position or surveyed point does
  poses::PoseReport poses_report;
  ground::ModelGroundReport ground_report;
  std::optional<GroundChoice> ground_choice;           // none in maps of earlier versions
  std::optional<alignment::AlignReport> align_report;  // nothing where photos lie by their poses alone
  std::optional<geo::Boundary> boundary;               // that the map is cut to
  std::optional<MapAppearance> appearance;             // absent: the run was killed before
  // As the map with this appearance shows them; none in maps of earlier versions or killed runs.
  std::optional<render::SeamShift> seams;
};

// Of the options that decide where photos lie.
Digest DigestOfPlacing(const MosaicOptions& options);

std::string WriteFacts(const FlightFacts& facts);
Result<FlightFacts> ParseFacts(std::string_view bytes);
// Of their inputs, by name. Errors: as ParseFacts.
Result<std::map<std::string, Digest>> DigestsOfFacts(std::string_view bytes);

}  // namespace skyquilt::pipeline
