// The sensors of common survey cameras: how wide the light-sensitive area is and how many pixels it has in
// the camera's widest still format. Looked up by the model as EXIF writes it. Constant; any thread. Source:
// the makers' data sheets; sensor widths of the classes 1/2.3", 1", 4/3", APS-C and full frame.
#pragma once

#include <optional>
#include <string_view>

namespace skyquilt::camera {

struct SensorSize {
  int native_width_px = 0;
  int native_height_px = 0;
  double width_mm = 0.0;
};

// Case does not matter.
std::optional<SensorSize> FindSensor(std::string_view model);

// How long a camera takes from reading the first row of its widest still format of so many pixels to the
// last, seconds (some sensors give pictures of four times the pixels, slower). Nothing for a camera that is
// not listed or exposes all rows at once (a mechanical shutter). Source: measured with blinking lights by
// users of OpenDroneMap (its RSCalibration describes how).
std::optional<double> FindReadoutS(std::string_view model, double megapixels);

// The factor from native pixels to those of an image that was resized, cropped to another aspect, or turned
// by a quarter: crops keep the pixel pitch and one full side.
double ScaleFromNative(int width_px, int height_px, int native_width_px, int native_height_px);

}  // namespace skyquilt::camera
