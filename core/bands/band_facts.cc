#include "core/bands/band_facts.h"

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

#include "core/bands/read_radiometry.h"
#include "core/bands/thermal.h"
#include "core/base/try.h"
#include "core/flight/photos/image_header.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::bands {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 15> kSpellings = {{
    {"nearinfrared", "nir"},
    {"infrared", "nir"},
    {"ir", "nir"},
    {"reg", "rededge"},
    {"re", "rededge"},
    {"gre", "green"},
    {"g", "green"},
    {"r", "red"},
    {"b", "blue"},
    {"blu", "blue"},
    {"pan", "panchro"},
    {"panchromatic", "panchro"},
    {"thermal", "lwir"},
    {"thermalinfrared", "lwir"},
    {"longwaveinfrared", "lwir"},
}};
constexpr std::array<std::string_view, 6> kByAlignRank = {"green", "red",  "rededge",
                                                          "nir",   "blue", "panchro"};
constexpr std::size_t kMaxNameBytes = 40;
constexpr std::size_t kMaxIdBytes = 80;

}  // namespace

std::string BandNameOf(std::string_view written) {
  std::string name;
  for (const char c : written.substr(0, kMaxNameBytes)) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) continue;
    name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  for (const auto& [spelling, usual] : kSpellings) {
    if (name == spelling) return std::string(usual);
  }
  return name;
}

int AlignRank(std::string_view band_name) {
  return static_cast<int>(std::find(kByAlignRank.begin(), kByAlignRank.end(), band_name) -
                          kByAlignRank.begin());
}

namespace {

using flight::XmpTags;

std::string FirstOf(const XmpTags& xmp, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    if (std::string text = xmp.Text(name); !text.empty()) return text;
  }
  return "";
}

// From far ultraviolet to thermal infrared.
std::optional<double> Wavelength(std::optional<double> nm) {
  return nm && *nm >= 100.0 && *nm <= 20'000.0 ? nm : std::nullopt;
}

// "840(+/-26)nm"
void ReadBandFrequency(const std::string& text, BandFacts& facts) {
  const std::size_t open = text.find('('), close = text.find(')');
  if (open == std::string::npos || close == std::string::npos || close < open) return;
  if (!facts.wavelength_nm) facts.wavelength_nm = Wavelength(flight::ParseXmpNumber(text.substr(0, open)));
  const std::size_t digit = text.find_first_of("0123456789", open);
  if (facts.width_nm || digit == std::string::npos || digit > close) return;
  if (const auto half = flight::ParseXmpNumber(text.substr(digit, close - digit)); half && *half > 0.0)
    facts.width_nm = 2.0 * *half;
}

PanelTags ReadPanelTags(const XmpTags& xmp) {
  PanelTags tags;
  // x and y of four corners
  if (const auto corners =
          flight::AllXmpNumbers(FirstOf(xmp, {"Camera:ReflectArea", "MicaSense:ReflectArea"}), 8))
    std::copy(corners->begin(), corners->end(), tags.area_px.emplace().begin());
  const auto albedo = flight::ParseXmpNumber(FirstOf(xmp, {"Camera:Albedo", "MicaSense:Albedo"}));
  if (albedo && *albedo > 0.0 && *albedo <= 1.2) tags.reflectance = albedo;
  tags.serial = FirstOf(xmp, {"Camera:PanelSerial", "MicaSense:PanelSerial"}).substr(0, kMaxIdBytes);
  return tags;
}

// Sentera's cameras number their captures anew in each flight.
std::string CaptureIdOf(const XmpTags& xmp) {
  std::string id = FirstOf(xmp, {"MicaSense:CaptureId", "Camera:CaptureUUID", "drone-dji:CaptureUUID"});
  if (id.empty()) {
    id = xmp.Text("Camera:ImageUniqueID");
    if (!id.empty()) id = xmp.Text("Camera:FlightUniqueID").substr(0, kMaxIdBytes / 2) + " " + id;
  }
  return id.substr(0, kMaxIdBytes);
}

// Of a JPEG with a thermal sensor's levels in it. Where those are damaged, the method says so.
BandFacts ReadFlirFacts(flight::ByteSource& source, const flight::ImageHeader& header) {
  BandFacts facts;
  facts.name = kThermalBand;
  facts.is_look_too = true;
  const Result<flight::FlirRecord> record = flight::ReadFlirRecord(source, header.flir);
  if (!record) {
    facts.radiometry.method = record.error().message;
  } else if (auto temperature = FlirTemperature(record->constants)) {
    facts.radiometry = *std::move(temperature);
  } else {
    facts.radiometry.method = "They lack the constants that make temperatures of the sensor's levels.";
  }
  return facts;
}

// A thermal TIFF that does not say what its levels are keeps them.
Radiometry ReadThermalRadiometry(const flight::ExifTable& exif, const XmpTags& xmp) {
  constexpr std::uint16_t kMakeTag = 0x010F;
  if (auto linear = LinearTemperature(exif.Text(flight::ExifIfd::kImage, kMakeTag), xmp))
    return *std::move(linear);
  Radiometry radiometry;
  radiometry.method = "stored levels";
  return radiometry;
}

}  // namespace

Result<BandFacts> ReadBandFacts(flight::ByteSource& source) {
  SKYQUILT_TRY_ASSIGN(const flight::ImageHeader header, flight::ReadImageHeader(source));
  if (!header.flir.empty()) return ReadFlirFacts(source, header);
  std::vector<flight::Remark> notes;  // the photo has them already
  const XmpTags xmp = flight::ReadXmp(header, source, notes);
  BandFacts facts;
  facts.name = BandNameOf(FirstOf(xmp, {"Camera:BandName", "drone-dji:BandName", "FLIR:BandName"}));
  if (facts.name.empty()) {
    return flight::Because(ErrorCode::kUnsupportedFormat, flight::RemarkCode::kBandUnnamed);
  }
  facts.wavelength_nm = Wavelength(xmp.Number("Camera:CentralWavelength"));
  facts.width_nm = xmp.Number("Camera:WavelengthFWHM");
  if (facts.width_nm && !(*facts.width_nm > 0.0)) facts.width_nm.reset();
  ReadBandFrequency(xmp.Text("drone-dji:BandFreq"), facts);
  facts.capture_id = CaptureIdOf(xmp);
  facts.rig = xmp.Text("Camera:RigName").substr(0, kMaxIdBytes);
  facts.is_panel = xmp.Number("Camera:CalibrationPicture").value_or(0.0) > 0.0;
  if (facts.is_panel) facts.panel = ReadPanelTags(xmp);
  facts.radiometry =
      facts.name == kThermalBand ? ReadThermalRadiometry(header.exif, xmp) : ReadRadiometry(header.exif, xmp);
  return facts;
}

}  // namespace skyquilt::bands
