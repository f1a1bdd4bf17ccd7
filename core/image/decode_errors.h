// What is said of a picture that cannot be decoded, whatever its format. Any thread.
#pragma once

#include <string>
#include <utility>

#include "core/base/result.h"

namespace skyquilt::image {

// kChanged: the picture is not the size that was asked for.
enum class DecodeOutcome { kDecoded, kDamaged, kChanged };

inline Error PictureDamaged(std::string detail) {
  return {ErrorCode::kCorrupt,
          "The picture is damaged or cut off and cannot be decoded. Copy the file from the camera again.",
          std::move(detail)};
}

inline Error PictureChanged() {
  return {ErrorCode::kCorrupt,
          "The picture is not the size its header said; the file has changed. Add it again.", ""};
}

}  // namespace skyquilt::image
