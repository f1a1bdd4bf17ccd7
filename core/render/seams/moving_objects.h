// MarkMoving: which cells of a view show a thing that was there for a moment only (a car on its way, a
// walker, a glint): another view shows bare ground there. Found pair by pair: a spot in which two views
// differ while all around they agree, and whose outline only one of them has. Spots that the other view shows
// farther from where its camera stood or nearer to it are left out: posts and slim trees lean, they do not
// move. Deterministic; any number of threads. Cells of SeamGrid.
#pragma once

#include <vector>

#include "core/render/seams/low_res_view.h"

namespace skyquilt::render {

// Sets `is_moving` of each view. cell_m: the cells' side on the ground.
void MarkMoving(std::vector<LowResView>& views, double cell_m, int threads);

}  // namespace skyquilt::render
