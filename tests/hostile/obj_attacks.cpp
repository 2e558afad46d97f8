#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile::obj {
namespace {

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const std::string kMaterial = "newmtl secret\nKd 1 0 0\n";

Case names_library(const std::string& name) {
  return {{{"model.obj", "mtllib " + name + "\nusemtl secret\n" + kTriangle}}};
}

Case missing(std::size_t k) {
  return names_library(std::vector<std::string>{"none.mtl", ".", "none/none.mtl", "none.mtl none.mtl"}[k]);
}

/// Names that lead out of the model's directory to a file that is there.
Case traversal(std::size_t k) {
  const std::vector<std::string> names = {
      "../secret.mtl",     "@/secret.mtl",          "link.mtl",
      "links/secret.mtl",  "none/../../secret.mtl", "..\\secret.mtl",
      "%2e%2e/secret.mtl", "..%2fsecret.mtl",       "file://" + std::string(kOutside) + "/secret.mtl"};
  Case made = names_library(names[k]);
  made.files.push_back({"../secret.mtl", kMaterial});
  made.files.push_back({"link.mtl", {}, "../secret.mtl"});
  made.files.push_back({"links", {}, ".."});
  made.most_materials = 0;
  return made;
}

Case absurd_index(std::size_t k) {
  const std::vector<std::string> faces = {
      "f 2147483647 1 2",    "f -2147483648 1 2", "f 99999999999999999999 1 2",
      "f 1//2147483647 2 3", "f 0 0 0",           "f 1/-2147483648/-2147483648 2 3"};
  return {{{"model.obj", kTriangle + faces[k] + "\n"}}};
}

/// The same materials by names beyond number, materials without contents, groups without number, one long line.
Case swollen(std::size_t k) {
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
  return {{{"model.obj", text}, {"a.mtl", materials}}};
}

}  // namespace

std::vector<Attack> attacks() {
  return {{"absurd counts", 6, absurd_index},
          {"swelling", 4, swollen},
          {"missing side files", 4, missing},
          {"path traversal", 9, traversal}};
}

}  // namespace sightline::hostile::obj
