// LabelSeams: which photo shows which cell. First every cell takes the photo that sees it best (ViewScore);
// then the borders move to where neighbours agree in colour, so that seams run over even ground and not
// through cars and roofs. Deterministic; one thread. Source: Boykov, Veksler and Zabih, Fast approximate
// energy minimization via graph cuts (2001), alpha expansion with the seam cost of Kwatra et al., Graphcut
// textures (2003).
#pragma once

#include <vector>

#include "core/render/seams/low_res_view.h"
#include "core/render/seams/seam_grid.h"

namespace skyquilt::render {

struct LabelOptions {
  bool moves_seams = true;  // false: the best view everywhere
  double height_m = 1.0;    // typical height above ground: the measure of how much worse a view is
  // Of the same cells; null: none. Its cells go to added photos where that fits better, and stay otherwise.
  const KnownLabels* known = nullptr;
};

// views[i] belongs to photo i.
SeamLabels LabelSeams(const std::vector<LowResView>& views, const SeamGrid& grid,
                      const LabelOptions& options);

}  // namespace skyquilt::render
