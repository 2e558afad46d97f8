#include "sightline/tests/hostile/attack.h"
#include "sightline/tests/importers/rvm_bytes.h"

namespace sightline::hostile::rvm {
namespace {

using tests::RvmBytes;

Case model(const RvmBytes& rvm) {
  return {{{"model.rvm", {reinterpret_cast<const char*>(rvm.bytes.data()), rvm.bytes.size()}}}};
}

/// A count of polygons, contours, vertices or words of text that the file does not hold.
Case absurd_count(std::size_t k) {
  constexpr std::uint32_t kCounts[] = {0xffffffff, 0x7fffffff, 0x40000000, 0x00ffffff};
  const std::uint32_t count = kCounts[k / 4];
  RvmBytes b;
  b.head();
  switch (k % 4) {
    case 0:
      b.group("g", 1).item(11).u32(count).end().group_end();
      break;
    case 1:
      b.group("g", 1).item(11).u32(1).u32(count).end().group_end();
      break;
    case 2:
      b.group("g", 1).item(11).u32(1).u32(1).u32(count).end().group_end();
      break;
    default:
      b.begin("CNTB").u32(2).u32(count).end().group_end();
      break;
  }
  return model(b.finish());
}

/// A chunk whose header leads back to itself or to one before.
Case cycle(std::size_t k) {
  RvmBytes b;
  b.head().group("g", 1);
  const std::size_t group = b.bytes.size();
  b.prim(8, {1, 2}).group_end().finish();
  b.put(group + 16, std::uint32_t(k == 0 ? group : k == 1 ? 0 : group - 8));
  return model(b);
}

Case nested(std::size_t) {
  RvmBytes b;
  b.head();
  for (int i = 0; i < 100000; ++i) b.group("", 1);
  return model(b.prim(8, {1, 2}));
}

/// What takes the most memory for its bytes: groups each of a colour of its own, or polygons without vertices.
Case swollen(std::size_t k) {
  RvmBytes b;
  b.head();
  if (k == 0)
    for (std::uint32_t i = 0; i < 40000; ++i)
      b.begin("CNTB")
          .u32(3)
          .u32(0)
          .floats({1.2345678e-30f, -1.2345678e-30f, -7.6543212e-20f})
          .u32(i)
          .u32(i << 24)
          .end();
  b.group("g", 1).item(11).u32(1).u32(400000);
  for (int i = 0; i < 400000; ++i) b.u32(0);
  return model(b.end());
}

Case attributes(const std::string& body) {
  return {{{"model.txt", "CADC_Attributes_File v1.0 , start: NEW , end: END , name_end: := , sep: &end&\n" + body}}};
}

/// A million elements within one another, opened or closed.
Case nested_elements(std::size_t k) {
  return attributes(k == 0 ? repeated("NEW /SITE\n", 1000000) : "NEW /SITE\n" + repeated("END\n", 1000000));
}

/// One element of a million attributes, a million elements of one, and values that are all separators.
Case swollen_attributes(std::size_t k) {
  std::string body = "NEW /SITE\n";
  for (int i = 0; k == 0 && i < 1000000; ++i) body += std::to_string(i) + ":=\n";
  if (k == 1) body += repeated("NEW /A\na:=\nEND\n", 1000000);
  if (k == 2) body += "a:=" + repeated("&end&", 1000000) + "\n";
  return attributes(body + "END\n");
}

}  // namespace

std::vector<Attack> attacks() {
  return {{"absurd counts", 16, absurd_count},
          {"cycles", 3, cycle},
          {"deep nesting (100,000)", 1, nested},
          {"swelling", 2, swollen}};
}

std::vector<Attack> attribute_attacks() {
  return {{"deep nesting (1,000,000)", 2, nested_elements}, {"swelling", 3, swollen_attributes}};
}

}  // namespace sightline::hostile::rvm
