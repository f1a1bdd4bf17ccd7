#include "server/preview/preview_messages.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/text/json_io.h"
#include "server/sandbox/message_checks.h"
#include "storage/db/ids.h"

namespace skyquilt::server {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxForgone = 64;

std::string DumpPreview(const Json& json) { return JsonText(json); }

Json FilesJson(const std::vector<storage::StoredFile>& files) {
  Json list = Json::array();
  for (const storage::StoredFile& file : files) list.push_back({file.name, file.stored_name});
  return list;
}

std::vector<storage::StoredFile> FilesOf(const Json& list) {
  std::vector<storage::StoredFile> files;
  for (const Json& file : list) files.push_back({file.at(0), file.at(1), 0});
  return files;
}

Json PreviewJson(const std::optional<storage::Preview>& preview) {
  if (!preview) return nullptr;
  return {{"photos", preview->photos},
          {"min_zoom", preview->min_zoom},
          {"max_zoom", preview->max_zoom},
          {"bounds", preview->bounds.ToArray()},
          {"changed", preview->changed.ToArray()}};
}

std::optional<storage::Preview> PreviewOf(const Json& json) {
  if (json.is_null()) return std::nullopt;
  storage::Preview preview;
  preview.photos = CountOf(json.at("photos"));
  preview.min_zoom = CountOf(json.at("min_zoom"));
  preview.max_zoom = CountOf(json.at("max_zoom"));
  preview.bounds = geo::LatLonBounds::FromArray(json.at("bounds"));
  preview.changed = geo::LatLonBounds::FromArray(json.at("changed"));
  return preview;
}

template <typename Parse>
auto Guarded(std::string_view text, Parse parse) -> decltype(parse(Json())) {
  try {
    return parse(ParseJson(text));
  } catch (const Json::exception& broken) {
    return Untrue(broken.what());
  }
}

Result<PreviewMessage> CheckedDrawn(const Json& json) {
  PreviewDrawn drawn{PreviewOf(json.at("preview")), json.at("forgone")};
  if (drawn.forgone.size() > kMaxForgone) return Untrue("too many photos");
  for (const std::string& name : drawn.forgone) {
    if (!storage::IsId(name)) return Untrue("a stored name is none of ours");
  }
  if (drawn.preview) {
    const storage::Preview& preview = *drawn.preview;
    if (preview.photos < 1 || !AreZooms(preview.min_zoom, preview.max_zoom) || !AreBounds(preview.bounds) ||
        !AreBounds(preview.changed)) {
      return Untrue("figures that no preview has");
    }
  }
  return PreviewMessage(std::move(drawn));
}

}  // namespace

std::string ToText(const PreviewPlace& place) {
  return DumpPreview({{"files_dir", place.files_dir.string()},
                      {"folder", place.folder.string()},
                      {"memory_bytes", place.memory_bytes}});
}

Result<PreviewPlace> ParsePlace(std::string_view text) {
  return Guarded(text, [](const Json& json) -> Result<PreviewPlace> {
    return PreviewPlace{json.at("files_dir").get<std::string>(), json.at("folder").get<std::string>(),
                        json.at("memory_bytes")};
  });
}

std::string ToText(const PreviewRequest& request) {
  return DumpPreview({{"fresh", FilesJson(request.fresh)},
                      {"tried", FilesJson(request.tried)},
                      {"preview", PreviewJson(request.preview)}});
}

Result<PreviewRequest> ParseRequest(std::string_view text) {
  return Guarded(text, [](const Json& json) -> Result<PreviewRequest> {
    return PreviewRequest{FilesOf(json.at("fresh")), FilesOf(json.at("tried")),
                          PreviewOf(json.at("preview"))};
  });
}

std::string ToText(const PreviewMessage& message) {
  if (const auto* begun = std::get_if<PhotoBegun>(&message))
    return DumpPreview({{"photo", begun->stored_name}});
  if (const auto* drawn = std::get_if<PreviewDrawn>(&message))
    return DumpPreview({{"preview", PreviewJson(drawn->preview)}, {"forgone", drawn->forgone}});
  const Error& error = std::get<Error>(message);
  return DumpPreview({{"error", Shortened(error.message, kMaxErrorBytes)},
                      {"detail", Shortened(error.detail, kMaxErrorBytes)}});
}

Result<PreviewMessage> ParsePreviewMessage(std::string_view text) {
  return Guarded(text, [](const Json& json) -> Result<PreviewMessage> {
    if (json.contains("photo")) {
      PhotoBegun begun{json.at("photo")};
      if (!storage::IsId(begun.stored_name)) return Untrue("a stored name is none of ours");
      return PreviewMessage(std::move(begun));
    }
    if (json.contains("preview")) return CheckedDrawn(json);
    return PreviewMessage(Error{ErrorCode::kIo, json.at("error"), json.at("detail")});
  });
}

}  // namespace skyquilt::server
