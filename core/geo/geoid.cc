#include "core/geo/geoid.h"

#include <proj.h>

#include <cmath>

namespace skyquilt::geo {
namespace {

struct ThreadProj {
  PJ_CONTEXT* context = proj_context_create();
  PJ* shift = nullptr;

  ThreadProj() {
    proj_log_level(context, PJ_LOG_NONE);
    // Inverse of vgridshift: ellipsoidal height = orthometric height + geoid height.
    shift = proj_create(context, "+proj=vgridshift +grids=egm96_15.gtx +multiplier=1");
  }
  ~ThreadProj() {
    proj_destroy(shift);
    proj_context_destroy(context);
  }
  ThreadProj(const ThreadProj&) = delete;
  ThreadProj& operator=(const ThreadProj&) = delete;
};

}  // namespace

std::optional<double> GeoidHeightM(const LatLon& position) {
  thread_local const ThreadProj proj;
  if (proj.shift == nullptr) return std::nullopt;
  const PJ_COORD in = proj_coord(DegToRad(position.lon_deg), DegToRad(position.lat_deg), 0.0, 0.0);
  const PJ_COORD out = proj_trans(proj.shift, PJ_FWD, in);
  if (!std::isfinite(out.xyz.z) || proj_errno(proj.shift) != 0) {
    proj_errno_reset(proj.shift);
    return std::nullopt;
  }
  return out.xyz.z;
}

}  // namespace skyquilt::geo
