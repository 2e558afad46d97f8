#include "sightline/importers/obj/internal/obj_reader.h"
#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile {
namespace {

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const std::string kMaterial = "newmtl secret\nKd 1 0 0\nd 0.5\n";

Case names_library(const std::string& name) {
  Case made = sound(one_file("model.obj", "mtllib " + name + "\nusemtl secret\n" + kTriangle));
  made.warns = true;
  made.least_items = 1;
  made.most_materials = 0;
  return made;
}

Case missing_library(std::size_t k) {
  return names_library(std::vector<std::string>{"none.mtl", ".", "none/none.mtl", "none.mtl none.mtl"}[k]);
}

Case absurd_index(std::size_t k) {
  const std::vector<std::string> faces = {
      "f 2147483647 1 2",    "f -2147483648 1 2", "f 99999999999999999999 1 2",
      "f 1//2147483647 2 3", "f 0 0 0",           "f 1/-2147483648/-2147483648 2 3"};
  return one_file("model.obj", kTriangle + faces[k] + "\n");
}

/// The same materials by names beyond number, materials without contents, groups without number, one long line.
Case obj_swollen(std::size_t k) {
  std::string text = kTriangle, materials;
  if (k == 0) {
    for (int i = 0; i < 3000; ++i)
      text += "mtllib " + repeated("./", std::size_t(1 + i % 300)) + repeated("/", std::size_t(i / 300)) + "a.mtl\n";
    materials = repeated("newmtl a\n", 3000);
  } else if (k == 1) {
    text += "mtllib a.mtl\n";
    materials = repeated("newmtl a\n", 30000);
  } else if (k == 2) {
    for (int i = 0; i < 50000; ++i) text += "g " + std::to_string(i) + "\nf 1 1 1\n";
  } else {
    text += "f" + repeated(" 1 2 3", 50000) + "\n";
  }
  Case made = sound(one_file("model.obj", text));
  made.files.push_back({"a.mtl", materials});
  return made;
}

/// A sound model with a material file that has changed.
Case changed_library(std::size_t k) {
  std::mt19937 random(unsigned(k) + 1);
  Case made = one_file("model.obj", "mtllib a.mtl\nusemtl secret\n" + kTriangle);
  made.files.push_back({"a.mtl", mutated(kMaterial + "newmtl b\nmap_Kd a.png\nTr 0.2\nKd 0.1 1e999 -1\n", random)});
  return made;
}

Case without_data(std::size_t) {
  return refused(one_file("model.obj", "just text\n"));
}

}  // namespace

std::vector<Target> obj_targets() {
  Target obj;
  obj = {.format = "obj",
         .extension = ".obj",
         .read = importers::read_obj,
         .memory_factor = importers::kObjMemoryFactor,
         .memory_constant = importers::kObjMemoryConstant,
         .mutations = 3000,
         .attacks = {{"mutated_materials", kAnyNumber, changed_library},
                     {"absurd_counts", 6, absurd_index},
                     {"swelling", 4, obj_swollen},
                     {"missing_side_files", 4, missing_library},
                     path_traversal(".mtl", kMaterial, names_library),
                     {"no_data", 1, without_data}},
         .noise = Expect::kEither};
  return {obj};
}

}  // namespace sightline::hostile
