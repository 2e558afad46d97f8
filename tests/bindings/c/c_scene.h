// A scene of the C API, and a small plant that C++ has as well.
#pragma once

#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/core/view.h"
#include "sightline/sightline.h"

/// Fails the test, with the library's message, unless the call succeeds.
#define EXPECT_OK(call) EXPECT_EQ(call, SL_OK) << sl_last_error()
#define ASSERT_OK(call) ASSERT_EQ(call, SL_OK) << sl_last_error()

namespace sightline::tests {

/// Ids of the C API as those of C++, and the reverse.
inline std::vector<core::ItemId> cpp_ids(std::span<const sl_item> items) {
  std::vector<core::ItemId> ids;
  for (const sl_item item : items) ids.push_back(core::ItemId{item});
  return ids;
}
inline std::vector<sl_item> c_ids(std::span<const core::ItemId> items) {
  std::vector<sl_item> ids;
  for (const core::ItemId item : items) ids.push_back(to_index(item));
  return ids;
}

struct Matrix {
  double m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
};
inline Matrix translation(double x, double y, double z) {
  Matrix matrix;
  matrix.m[12] = x, matrix.m[13] = y, matrix.m[14] = z;
  return matrix;
}

/// Parameters of a primitive that is not degenerate.
inline const std::vector<std::vector<float>>& some_parameters() {
  static const std::vector<std::vector<float>> kAll = {
      {1, 1.2f, 0.5f, 0.6f, 0.1f, 0.2f, 1},                    // pyramid
      {1, 0.8f, 0.6f},                                         // box
      {0.3f, 0.6f, 0.2f, 2},                                   // rectangular torus
      {0.6f, 0.2f, 1.5f},                                      // circular torus
      {0.5f, 0.3f},                                            // elliptical dish
      {0.5f, 0.2f},                                            // spherical dish
      {0.5f, 0.3f, 1, 0.1f, 0.2f, 0.05f, 0.1f, -0.1f, 0.15f},  // snout
      {0.4f, 1},                                               // cylinder
      {0.9f},                                                  // sphere
      {-0.4f, 0.7f},                                           // line
  };
  return kAll;
}

inline sl_primitive some_primitive(sl_kind kind) {
  sl_primitive primitive = {};
  primitive.kind = kind;
  const std::vector<float>& values = some_parameters()[std::size_t(kind)];
  std::copy(values.begin(), values.end(), primitive.of.parameters);
  return primitive;
}

/// A scene that lives as long as this.
struct CScene {
  sl_scene scene = {0};
  sl_node root = {0};

  CScene() {
    EXPECT_OK(sl_scene_create(&scene));
    sl_scene_info info = SL_SCENE_INFO_INIT;
    EXPECT_OK(sl_scene_get(scene, &info));
    root = info.root;
  }
  ~CScene() {
    if (scene.id) {
      EXPECT_OK(sl_scene_destroy(scene));
    }
  }
  CScene(const CScene&) = delete;
  CScene& operator=(const CScene&) = delete;

  sl_node add_node(sl_node parent, const char* name = nullptr, const Matrix& transform = {}) const {
    sl_node node = {0};
    EXPECT_OK(sl_node_add(scene, parent, name, transform.m, &node));
    return node;
  }
  sl_item add(sl_node node, sl_kind kind, const Matrix& placement = {}, sl_material material = {0}) const {
    const sl_primitive primitive = some_primitive(kind);
    sl_item item = SL_NO_ITEM;
    EXPECT_OK(sl_item_add_primitive(scene, node, &primitive, placement.m, material, &item));
    return item;
  }
};

/// n^3 primitives of all kinds, two metres apart, in both APIs with the same numbers of items.
inline void fill_grid(const CScene& c, core::Scene& scene, int n) {
  for (int i = 0; i < n * n * n; ++i) {
    const double x = 2.0 * (i % n), y = 2.0 * (i / n % n), z = 2.0 * (i / n / n);
    const sl_kind kind = i % 10;
    c.add(c.root, kind, translation(x, y, z));
    scene.add_primitive(scene.root(), core::make_primitive(core::Kind(kind), some_parameters()[std::size_t(kind)]),
                        core::translation({x, y, z}));
  }
}

/// One view in both APIs: from among the items of a grid, or from outside it.
struct BothViews {
  sl_view c = SL_VIEW_INIT;
  core::View cpp;

  BothViews(core::dvec3 eye, core::dvec3 target, double aspect = 1.5)
      : cpp(*core::View::perspective({eye, target, {0, 0, 1}}, 0.8, aspect, 0.1, 100.0)) {
    const sl_pose pose = {{eye.x, eye.y, eye.z}, {target.x, target.y, target.z}, {0, 0, 1}};
    EXPECT_OK(sl_view_perspective(&pose, 0.8, aspect, 0.1, 100.0, &c));
  }
};

}  // namespace sightline::tests
