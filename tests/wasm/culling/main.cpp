// What tests of the JavaScript package ask of the library in this process.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "box_answers.h"
#include "exact_pairs.h"
#include "timing.h"

namespace {

constexpr const char* kUsage =
    "usage: wasm_culling_native boxes FILE\n"
    "       wasm_culling_native scenes FILE\n"
    "       wasm_culling_native pairs FILE COUNT BATCH\n"
    "       wasm_culling_native check PAIRS ANSWERS\n"
    "       wasm_culling_native plant FILE ITEMS\n"
    "       wasm_culling_native time FILE CALLS\n";

}  // namespace

int main(int argc, char** argv) {
  using namespace sightline::tests;
  const std::vector<std::string> a(argv + 1, argv + argc);
  const auto number = [&](std::size_t i) { return std::strtoull(a[i].c_str(), nullptr, 10); };
  const auto is = [&](const char* command, std::size_t count) { return a.size() == count && a[0] == command; };
  bool done = false;
  if (is("boxes", 2))
    done = write_box_answers(a[1]);
  else if (is("scenes", 2))
    done = write_scene_answers(a[1]);
  else if (is("pairs", 4))
    done = write_pairs(a[1], number(2), number(3));
  else if (is("check", 3))
    done = check_pairs(a[1], a[2]);
  else if (is("plant", 3))
    done = write_plant_boxes(a[1], number(2));
  else if (is("time", 3))
    done = time_culling(a[1], std::max(1, int(number(2))));
  else
    std::fputs(kUsage, stderr);
  if (!done) std::fputs("wasm_culling_native: failed\n", stderr);
  return done ? 0 : 1;
}
