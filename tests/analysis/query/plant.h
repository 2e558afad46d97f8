// A scene for the tests of query: two files, attributes at several depths, all kinds of values.
#pragma once

#include <gtest/gtest.h>

#include "sightline/core/primitive.h"
#include "sightline/core/scene.h"

namespace sightline::tests {

class QueryTest : public testing::Test {
 protected:
  using Item = core::ItemId;

  core::NodeId node(core::NodeId parent, const char* name, const core::Scene::Attributes& attributes = {}) {
    const core::NodeId added = scene.add_node(parent, name);
    for (const auto& [key, value] : attributes) scene.set_attribute(added, key, value);
    return added;
  }
  Item box(core::NodeId parent, double x, float side, core::MaterialId material = {}) {
    return scene.add_primitive(parent, core::Box{side, side, side}, core::translation({x, 0.0, 0.0}), material);
  }
  Item sphere(core::NodeId parent, double x, float diameter) {
    return scene.add_primitive(parent, core::Sphere{diameter}, core::translation({x, 0.0, 0.0}));
  }

  core::Scene scene;
  core::MaterialId steel = scene.add_material({"Steel", {0.5f, 0.5f, 0.5f}}),
                   plain = scene.add_material({"", {1, 0, 0}});
  core::NodeId a = node(scene.root(), "a.rvm"), b = node(scene.root(), "b.ifc");
  core::NodeId line = node(a, "/LINE-1", {{"System", "CW"}, {"DN", "150 mm"}});
  core::NodeId valve = node(line, "/VALVE", {{"DN", "80 mm"}, {"Type", "Gate"}});
  core::NodeId line10 = node(a, "/LINE-10", {{"SYSTEM", "HW"}, {"DN", "300"}});
  core::NodeId empty = node(b, "none", {{"System", "no items"}});
  Item pipe = box(line, 0.0, 1.0f, steel), body = sphere(valve, 2.0, 0.5f), wheel = box(valve, 2.5, 0.25f, plain),
       hot = box(line10, 10.0, 2.0f), other = sphere(b, 20.0, 0.125f);
};

}  // namespace sightline::tests
