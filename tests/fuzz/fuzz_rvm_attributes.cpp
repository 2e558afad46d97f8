// Attribute files of RVM models, for a scene of a few groups.
#include "sightline/core/snapshot.h"
#include "sightline/importers/rvm/internal/rvm_attributes.h"
#include "sightline/tests/fuzz/fuzz_target.h"

namespace {

using namespace sightline;

core::NodeId model(core::Scene& scene) {
  const core::NodeId file = scene.add_node(scene.root(), "fuzz.rvm");
  const core::NodeId site = scene.add_node(file, "/SITE");
  for (const char* name : {"/A", "/B", "/A", ""}) scene.add_primitive(scene.add_node(site, name), core::Sphere{1.0f});
  return site;
}

std::size_t attribute_bytes(const core::Scene& scene) {
  std::size_t bytes = 0;
  scene.for_each_node(scene.root(), [&](core::NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
    for (const auto& [key, value] : scene.attributes(node)) bytes += key.size() + value.size();
    fuzz::require(scene.attributes(node).size() <= importers::kMaxAttributesPerElement,
                  "no more attributes than allowed");
  });
  return bytes;
}

void check(std::span<const std::byte> bytes, const importers::ImportOptions& options) {
  core::Scene scene;
  model(scene);
  const std::size_t nodes = scene.node_count(), items = scene.item_count();
  const auto report = importers::read_rvm_attributes(bytes, "fuzz.txt", scene, scene.root(), options);
  fuzz::require(scene.node_count() == nodes && scene.item_count() == items, "no node or item added");
  constexpr std::size_t kMostPerByte = 3;  // a byte of Windows-1252 as UTF-8
  fuzz::require(attribute_bytes(scene) <= (report ? kMostPerByte * bytes.size() : 0),
                "attributes out of the file, none after a failure");
  if (!report) {
    const std::string& message = report.error().message;
    fuzz::require(message == importers::kCancelled || message.find("fuzz.txt") != message.npos,
                  "an error that names the file");
  }
  fuzz::require(scene.commit().has_value(), "a scene that can be committed");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::vector<std::byte> exact(fuzz::bytes_of(data, size).begin(), fuzz::bytes_of(data, size).end());
  importers::ImportOptions options;
  check(exact, options);
  options.lenient = true;
  check(exact, options);
  options.progress = [](double share) { return share < 0.5; };
  check(exact, options);
  return 0;
}
