#include "tests/support/rendered_once.h"

#include <algorithm>
#include <list>
#include <mutex>

namespace skyquilt::test {
namespace {

constexpr std::size_t kMostKeptBytes = std::size_t{256} << 20;

struct KeptPicture {
  simulate::WorldOptions world;
  camera::Intrinsics lens;
  Eigen::Vector4d rotation;
  Eigen::Vector3d translation;
  simulate::RenderPhotoOptions render;
  image::DecodedImage image;

  bool IsOf(const KeptPicture& other) const {
    return world == other.world && lens == other.lens && rotation == other.rotation &&
           translation == other.translation && render == other.render;
  }
};

struct KeptPictures {
  std::mutex mutex;
  std::list<KeptPicture> last_asked_first;
  std::size_t bytes = 0;
};

KeptPictures& Kept() {
  static KeptPictures kept;
  return kept;
}

}  // namespace

image::DecodedImage RenderedOnce(const simulate::SimulatedFlight& flight, std::size_t index) {
  const simulate::SimulatedPhoto& photo = flight.photos.at(index);
  const geo::Rigid3& pose = photo.pose.cam_from_enu;
  KeptPicture asked{flight.world.options(), flight.options.intrinsics,
                    pose.rotation.coeffs(), pose.translation,
                    photo.render,           {}};
  KeptPictures& kept = Kept();
  {
    const std::lock_guard lock(kept.mutex);
    auto& pictures = kept.last_asked_first;
    const auto found = std::find_if(pictures.begin(), pictures.end(),
                                    [&](const KeptPicture& one) { return one.IsOf(asked); });
    if (found != pictures.end()) {
      pictures.splice(pictures.begin(), pictures, found);
      return found->image;
    }
  }
  asked.image = simulate::RenderSimulatedPhoto(flight, index);
  image::DecodedImage image = asked.image;
  const std::lock_guard lock(kept.mutex);
  kept.bytes += image.rgb.size();
  kept.last_asked_first.push_front(std::move(asked));
  while (kept.bytes > kMostKeptBytes) {
    kept.bytes -= kept.last_asked_first.back().image.rgb.size();
    kept.last_asked_first.pop_back();
  }
  return image;
}

}  // namespace skyquilt::test
