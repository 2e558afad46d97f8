#include "sightline/bindings/wasm/views.h"

#include <glm/gtc/type_ptr.hpp>

#include "sightline/bindings/wasm/call.h"

namespace sightline::wasm {

SIGHTLINE_EXPORT ViewObject* sl_view_create(const double* eye_from_world, const double* clip_from_eye,
                                            std::uint32_t depth, std::int32_t width, std::int32_t height) {
  return attempt([&]() -> core::Expected<ViewObject*> {
    auto view = core::View::from_matrices(glm::make_mat4(eye_from_world), glm::make_mat4(clip_from_eye),
                                          core::ClipDepth(depth));
    if (!view) return tl::unexpected(view.error());
    return new ViewObject{std::move(*view), width, height};
  });
}

SIGHTLINE_EXPORT void sl_view_destroy(ViewObject* view) {
  delete view;
}

/// Replaces the matrices; keeps sections and layers.
SIGHTLINE_EXPORT bool sl_view_set(ViewObject* object, const double* eye_from_world, const double* clip_from_eye,
                                  std::uint32_t depth, std::int32_t width, std::int32_t height) {
  return attempt([&]() -> core::Expected<bool> {
    auto view = core::View::from_matrices(glm::make_mat4(eye_from_world), glm::make_mat4(clip_from_eye),
                                          core::ClipDepth(depth));
    if (!view) return tl::unexpected(view.error());
    view->sections = std::move(object->view.sections);
    view->section_mode = object->view.section_mode;
    view->layers = object->view.layers;
    *object = {std::move(*view), width, height};
    return true;
  });
}

/// `planes`: four numbers each, of the half-space that is kept.
SIGHTLINE_EXPORT bool sl_view_sections(ViewObject* object, const double* planes, std::uint32_t count, bool any) {
  return attempt([&]() -> core::Expected<bool> {
    if (count > core::kMaxSectionPlanes)
      return core::fail("view: expected at most " + std::to_string(core::kMaxSectionPlanes) + " section planes, got " +
                        std::to_string(count));
    object->view.sections.clear();
    for (std::uint32_t i = 0; i < count; ++i, planes += 4)
      object->view.sections.push_back({{planes[0], planes[1], planes[2]}, planes[3]});
    object->view.section_mode = any ? core::SectionMode::kUnion : core::SectionMode::kIntersection;
    return true;
  });
}

SIGHTLINE_EXPORT void sl_view_layers(ViewObject* object, std::uint32_t layers) {
  object->view.layers = layers;
}

}  // namespace sightline::wasm
