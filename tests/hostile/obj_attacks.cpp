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

/// Names that differ from those of files outside in case alone, which the search for similar names must not follow.
Attack path_traversal_by_similar_names() {
  Attack made = path_traversal(".mtl", kMaterial, [](std::string name) {
    for (char& c : name)
      if (c >= 'a' && c <= 'z') c = char(c - 'a' + 'A');
    return names_library(name);
  });
  made.name = "path_traversal_by_similar_names";
  return made;
}

/// Materials under names beyond number, materials without contents, groups without number, one long line.
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

/// One line continued without end, lines that end in CR alone, names and libraries without number, each with a mistake.
Case obj_odd(std::size_t k) {
  std::string text = kTriangle, materials;
  if (k == 0) {
    text += "f 1 2 3" + repeated(" \\\n", 100000);
  } else if (k == 1) {
    text = repeated("v 0 0 0\r", 20000) + repeated("f 1 2 3\r", 20000) + "\n";
  } else if (k == 2) {
    for (int i = 0; i < 20000; ++i) text += "usemtl \xff" + std::to_string(i) + "\nf 1 1 1\n";
  } else if (k == 3) {
    for (int i = 0; i < 1000; ++i) text += "mtllib " + std::to_string(i) + " B\\" + std::to_string(i) + "%20.mtl\n";
  } else if (k == 4) {
    text += "mtllib a.mtl\n";
    for (int i = 0; i < 1000; ++i) {
      materials += "newmtl " + std::to_string(i) + "\nmap_Kd -s -o " + std::to_string(i) + ".png\n";
      text += "usemtl " + std::to_string(i) + "\nf 1 2 3\n";
    }
  } else {
    text += repeated("v nan 0 0 1e39 -1 nan\nvn 0 0\nf -1 -2//-1 1\nf 1//7 2//0 3//-9999999\n", 5000);
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
                     {"odd_text", 6, obj_odd},
                     {"missing_side_files", 4, missing_library},
                     path_traversal(".mtl", kMaterial, names_library),
                     path_traversal_by_similar_names(),
                     {"no_data", 1, without_data}},
         .noise = Expect::kEither};
  return {obj};
}

}  // namespace sightline::hostile
