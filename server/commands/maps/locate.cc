#include "core/pipeline/report/locate.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/commands/commands.h"
#include "server/terminal/fail.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

struct LocateOptions {
  std::string map_dir;
  std::string photo;
  std::vector<double> pixel;
  std::vector<double> lon_lat;
};

std::string LocatedWithin(const std::optional<double>& sigma_m) {
  return sigma_m ? fmt::format("+-{:.2f} m", *sigma_m) : "with an unknown error";
}

void Run(const LocateOptions& options) {
  if (options.pixel.empty() == options.lon_lat.empty() || options.pixel.empty() != options.photo.empty()) {
    Refuse("skyquilt locate", "Give either --photo with --pixel, or --lonlat.");
  }
  const Result<std::string> text = storage::ReadWholeFile(options.map_dir + "/locate.json");
  if (!text) {
    Fail("skyquilt locate",
         {ErrorCode::kNotFound,
          options.map_dir + " has no locate.json. Give the folder that \"stitch\" wrote."});
  }
  const pipeline::LocatedMap map = OrFail("skyquilt locate", pipeline::ParseLocateJson(*text));
  if (!options.pixel.empty()) {
    const pipeline::GroundPoint point = OrFail(
        "skyquilt locate", pipeline::GroundAtPixel(map, options.photo, {options.pixel[0], options.pixel[1]}));
    fmt::print("{:.9f},{:.9f} {}\n", point.position.lon_deg, point.position.lat_deg,
               LocatedWithin(point.sigma_m));
    return;
  }
  const geo::LatLon position =
      OrFail("skyquilt locate", geo::LatLon::Make(options.lon_lat[1], options.lon_lat[0]));
  const std::vector<pipeline::Sighting> sightings = pipeline::PhotosAtPoint(map, position);
  if (sightings.empty()) fmt::print(stderr, "No photo of this map shows that place.\n");
  for (const pipeline::Sighting& sighting : sightings) {
    fmt::print("{} {:.2f},{:.2f} {}, {:.1f} degrees off the vertical{}\n", sighting.photo,
               sighting.pixel_in_image.x(), sighting.pixel_in_image.y(), LocatedWithin(sighting.sigma_m),
               geo::RadToDeg(sighting.off_nadir_rad),
               sighting.sharpness ? fmt::format(", sharpness {:.2f}", *sighting.sharpness) : "");
  }
}

}  // namespace

void AddLocateCommand(CLI::App& app) {
  const auto options = std::make_shared<LocateOptions>();
  CLI::App* command = app.add_subcommand("locate", "Which photos see a place, or where a photo's pixel lies");
  command->add_option("DIR", options->map_dir, "Folder that \"stitch\" wrote")
      ->required()
      ->check(CLI::ExistingDirectory);
  command->add_option("--photo", options->photo, "Name of a photo");
  command->add_option("--pixel", options->pixel, "X,Y in that photo; 0,0 is the centre of the first pixel")
      ->delimiter(',')
      ->expected(2);
  command->add_option("--lonlat", options->lon_lat, "LON,LAT in degrees")->delimiter(',')->expected(2);
  command->footer("Example:\n  skyquilt locate map --photo DJI_0007.JPG --pixel 2000,1500");
  command->callback([options] { Run(*options); });
}

}  // namespace skyquilt::server
