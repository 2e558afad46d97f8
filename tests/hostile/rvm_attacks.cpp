#include "sightline/importers/rvm/internal/rvm_attributes.h"
#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/tests/hostile/attack.h"
#include "sightline/tests/importers/rvm_bytes.h"

namespace sightline::hostile {
namespace {

using tests::RvmBytes;

Case rvm_model(const RvmBytes& rvm) {
  return one_file("model.rvm", text_of(rvm.bytes));
}

/// A count of polygons, contours, vertices or words of text that the file does not hold.
Case rvm_count(std::size_t k) {
  constexpr std::uint32_t kCounts[] = {0xffffffff, 0x7fffffff, 0x40000000, 0x00ffffff, 1000};
  const std::uint32_t count = kCounts[k / 5];
  RvmBytes b;
  if (k % 5 == 4) return refused(rvm_model(b.begin("HEAD").u32(2).u32(count).end().finish()));
  b.head();
  if (k % 5 == 0) b.group("g", 1).item(11).u32(count);
  if (k % 5 == 1) b.group("g", 1).item(11).u32(1).u32(count);
  if (k % 5 == 2) b.group("g", 1).item(11).u32(1).u32(1).u32(count).floats({1, 2, 3});
  if (k % 5 == 3) b.begin("CNTB").u32(2).u32(count);
  return damaged(rvm_model(b.end().group_end().finish()));
}

/// A chunk whose header leads back to itself or to one before; its contents lead on.
Case rvm_cycle(std::size_t k) {
  RvmBytes b;
  b.head().group("g", 1);
  const std::size_t group = b.bytes.size();
  b.prim(8, {1, 2}).group_end().finish();
  b.put(group + 16, std::uint32_t(k == 0 ? group : k == 1 ? 0 : group - 8));
  return sound(rvm_model(b));
}

/// Groups within one another, which stay open or are closed.
Case rvm_nested(std::size_t k) {
  constexpr int kDepth = 100000;
  RvmBytes b;
  b.head();
  for (int i = 0; i < kDepth; ++i) b.group("", 1);
  b.prim(8, {1, 2});
  if (k == 0) return damaged(rvm_model(b));
  for (int i = 0; i < kDepth; ++i) b.group_end();
  return sound(rvm_model(b.finish()));
}

/// The most memory for their bytes: groups each of a colour of its own, tiny items, empty facet groups, translucent
/// layers, polygons without vertices.
Case rvm_swollen(std::size_t k) {
  RvmBytes b;
  b.head();
  if (k > 0) b.group("", 1);
  for (std::uint32_t i = 0; k < 4 && i < 40000; ++i) {
    const std::uint32_t colour = i << 24, layer = i % 100 << 24;
    if (k == 0)
      b.begin("CNTB").u32(3).u32(0).floats({1.2345678e-30f, -1.2345678e-30f, -7.6543212e-20f}).u32(i).u32(colour).end();
    if (k == 1) b.prim(9, {1});
    if (k == 2) b.item(11).u32(0).end();
    if (k == 3) b.begin("OBST").u32(1).u32(9).matrix().floats({-1, -1, -1, 1, 1, 1}).u32(layer).f32(2).end();
  }
  if (k == 4) b.item(11).u32(1).u32(400000).bytes.resize(b.bytes.size() + 4 * 400000);
  if (k == 4) b.end();
  return damaged(rvm_model(b));
}

Case text_swollen(std::size_t k) {
  const std::string head = "HEAD\n1 1\n\n\n\n\nMODL\n1 1\n\n\n", group = "CNTB\n1 2\n\n0 0 0\n1\n";
  if (k == 0) return one_file("model.rev", head + repeated("CNTB\n1 2\nA\n0 0 0\n1\nCNTE\n1 2\n", 30000) + "END:\n");
  if (k == 1) return damaged(one_file("model.rev", head + repeated(group, 30000) + "END:\n"));
  return one_file("model.rev", head + group + "PRIM\n1 1\n11\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1 1 1\n250000\n" +
                                   repeated("0\n", 250000) + "CNTE\n1 1\nEND:\n");
}

Case attributes(const std::string& body) {
  return one_file("model.txt",
                  "CADC_Attributes_File v1.0 , start: NEW , end: END , name_end: := , sep: &end&\n" + body);
}

/// A million elements within one another, opened or closed.
Case nested_elements(std::size_t k) {
  return damaged(attributes(k == 0 ? repeated("NEW /SITE\n", 1000000) : "NEW /SITE\n" + repeated("END\n", 1000000)));
}

/// One element of a million attributes, a million elements of one, and values that are all separators.
Case swollen_attributes(std::size_t k) {
  std::string body = "NEW /SITE\n";
  for (int i = 0; k == 0 && i < 1000000; ++i) body += std::to_string(i) + ":=\n";
  if (k == 1) body += repeated("NEW /A\na:=\nEND\n", 1000000);
  if (k == 2) body += "a:=" + repeated("&end&", 1000000) + "\n";
  return k == 0 ? damaged(attributes(body + "END\n")) : sound(attributes(body + "END\n"));
}

/// The groups that attribute files speak of.
void add_groups(core::Scene& scene) {
  const core::NodeId site = scene.add_node(scene.add_node(scene.root(), "model.rvm"), "/SITE");
  for (const char* name : {"/A", "/B", "/A", ""}) scene.add_primitive(scene.add_node(site, name), core::Sphere{1.0f});
}

core::Expected<importers::ImportReport> read_rvm_file(std::span<const std::byte> bytes,
                                                      const std::filesystem::path& path, core::Scene& scene,
                                                      core::NodeId parent, const importers::ImportOptions& options) {
  return importers::read_rvm(bytes, path.filename().string(), scene, parent, options);
}

/// END: counts as read once its header is whole: its version word is not needed.
Needs rvm_needs(std::string_view seed) {
  return {seed.rfind(std::string("\0\0\0E\0\0\0N\0\0\0D\0\0\0:", 16)) + 24, 0};
}

Needs text_needs(std::string_view seed) {
  return {seed.rfind("END:") + 4, 0};
}

}  // namespace

std::vector<Target> rvm_targets() {
  using namespace importers;
  Target binary, text, attribute_file;
  binary = {.format = "rvm",
            .extension = ".rvm",
            .read = read_rvm_file,
            .memory_factor = kRvmMemoryFactor,
            .memory_constant = kRvmMemoryConstant,
            .mutations = 100000,
            .attacks = {{"absurd_counts", 25, rvm_count},
                        {"cycles", 3, rvm_cycle},
                        {"deep_nesting", 2, rvm_nested},
                        {"swelling", 5, rvm_swollen}},
            .needs = rvm_needs};
  text = {.format = "rvm",
          .extension = ".rev",
          .read = read_rvm_file,
          .memory_factor = kRvmTextMemoryFactor,
          .memory_constant = kRvmMemoryConstant,
          .mutations = 10000,
          .attacks = {{"swelling", 3, text_swollen}},
          .needs = text_needs};
  attribute_file = {.format = "rvm_attributes",
                    .extension = ".txt",
                    .read = read_rvm_attributes,
                    .mutations = 4000,
                    .attacks = {{"deep_nesting", 2, nested_elements}, {"swelling", 3, swollen_attributes}},
                    .prepare = add_groups};
  return {binary, text, attribute_file};
}

}  // namespace sightline::hostile
