// A scene with what is made from it: what the package "sightline" adds to culling.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "sightline/bindings/wasm/views.h"
#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/occlusion/solid_occluders.h"
#include "sightline/gpuprims/internal/joints.h"
#include "sightline/importers/import.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::wasm {

/// Nodes have numbers, in the order in which they came: JavaScript has no handles.
struct Model {
  core::Scene scene = {};
  std::vector<core::NodeId> nodes = {};
  std::unordered_map<std::uint32_t, std::uint32_t> number_of = {};  // by NodeId::index
  std::vector<core::MeshId> meshes = {};
  std::vector<core::MaterialId> materials = {};
  importers::ImportReport report = {};

  // Made for the last commit: null or empty before the first, the tracer before the first ray, joints before records.
  std::unique_ptr<core::Snapshot> snapshot = {};
  std::optional<culling::CpuCuller> culler = {};
  std::optional<raytrace::Tracer> tracer = {};
  std::optional<gpuprims::Joints> joints = {};

  core::ThreadPool threads{};
  culling::SolidOccluders solids = {};
  core::VisibleSet set = {};

  // Answers lie in these until the next one.
  std::vector<std::uint32_t> words = {};
  std::vector<float> floats = {};
  std::vector<double> doubles = {};
  std::vector<std::uint8_t> bytes = {};
  std::string text = {};
  std::vector<raytrace::Hit> hits = {};

  Model() { find_nodes(); }
  /// Gives numbers to nodes that have none.
  void find_nodes();
  core::Expected<void> commit();
};

}  // namespace sightline::wasm
