// Writes scenes of analytic primitives for a browser to draw, and what each pixel of their images should show. Takes
// the path of the files to write, without suffix:
//   PATH.json  the scenes: their records as the wasm module packs them, their views, and where in PATH.bin they lie
//   PATH.bin   first all records (32-bit words), then kNumbers floats for each pixel, row by row from the top
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "sightline/core/snapshot.h"
#include "sightline/gpuprims/internal/packing.h"
#include "sightline/gpuscene/internal/batch_kinds.h"
#include "sightline/tests/render/pixel_reference.h"

namespace {

using namespace sightline;
using core::Affine;
using core::dmat3;
using core::dvec3;
using nlohmann::json;

constexpr int kWidth = 96, kHeight = 64;
constexpr double kAspect = double(kWidth) / kHeight;
/// How many of the five rays through a pixel and close by hit; 1 when they agree; their least and greatest eye depth;
/// normal and item of the ray through the centre; 1 on a cut face.
constexpr int kNumbers = 9;

/// A camera in the terms of three.js.
struct Camera {
  core::Pose pose;
  bool orthographic = false;
  double left, right, bottom, top;  // on the near plane
  double near, far;
};

Camera look(const dvec3& eye, const dvec3& target, double fovy = 1.0, double near = 0.05, double far = 500.0) {
  const double top = near * std::tan(0.5 * fovy);
  return {{eye, target, {0.0, 0.0, 1.0}}, false, -top * kAspect, top * kAspect, -top, top, near, far};
}

Camera parallel(const dvec3& eye, const dvec3& target, double height, double near = 0.05, double far = 500.0) {
  const double top = 0.5 * height;
  return {{eye, target, {0.0, 0.0, 1.0}}, true, -top * kAspect, top * kAspect, -top, top, near, far};
}

Camera off_axis(const dvec3& eye, const dvec3& target) {
  return {{eye, target, {0.0, 0.0, 1.0}}, false, -0.02, 0.05, -0.03, 0.02, 0.1, 300.0};
}

/// A camera that sees about the same while it looks elsewhere: its window lies aside of the axis, by far more than it
/// is wide. `direction`: of the given camera.
Camera aside(Camera camera, const dvec3& direction) {
  const dvec3 axis = glm::normalize(direction + dvec3(0.1, 0.4, -0.3));
  const dvec3 right = glm::normalize(glm::cross(axis, camera.pose.up)), up = glm::cross(right, axis);
  const double scale = camera.near / glm::dot(direction, axis);
  camera.pose.target = camera.pose.eye + axis;
  camera.left += scale * glm::dot(direction, right);
  camera.right += scale * glm::dot(direction, right);
  camera.bottom += scale * glm::dot(direction, up);
  camera.top += scale * glm::dot(direction, up);
  return camera;
}

struct Item {
  core::Primitive primitive;
  Affine placed = {};
  bool drawn = true;
  bool mesh = false;  ///< a box that the page draws as a mesh of three.js
};

struct Scene {
  std::string name;
  std::vector<Item> items;
  Camera camera;
  std::vector<core::Plane> sections = {};
  bool unite = false;
};

core::View view_of(const Scene& scene) {
  const Camera& c = scene.camera;
  core::View view = c.orthographic ? *core::View::orthographic(c.pose, c.top - c.bottom, kAspect, c.near, c.far)
                                   : *core::View::asymmetric(c.pose, c.left, c.right, c.bottom, c.top, c.near, c.far);
  view.sections = scene.sections;
  view.section_mode = scene.unite ? core::SectionMode::kUnion : core::SectionMode::kIntersection;
  return view;
}

/// A colour for each item that no other has.
core::vec3 colour_of(std::size_t item) {
  const double turn = 0.618034 * double(item);
  const auto wave = [&](double phase) { return float(0.45 + 0.3 * std::sin(core::kFullTurn * (turn + phase))); };
  return {wave(0.0), wave(1.0 / 3.0), wave(2.0 / 3.0)};
}

class Writer {
 public:
  void add(const Scene& scene) {
    json entry = {{"name", scene.name}, {"unite", scene.unite}, {"meshes", json::array()}, {"sections", json::array()}};
    add_camera(entry, scene);
    for (const core::Plane& plane : scene.sections)
      entry["sections"].push_back({plane.normal.x, plane.normal.y, plane.normal.z, plane.offset});
    add_items(entry, scene);
    entry["pixels"] = pixels_.size();
    add_pixels(scene);
    scenes_.push_back(std::move(entry));
  }

  bool write(const std::string& path) const {
    json kinds;
    for (int i = 0; i < gpuscene::kBatchKindCount; ++i)
      if (gpuscene::is_ray_cast(gpuscene::BatchKind(i)))
        kinds.push_back(
            {gpuscene::name_of(gpuscene::BatchKind(i)), 4 * gpuscene::texels_per_record(gpuscene::BatchKind(i))});
    std::ofstream text(path + ".json"), numbers(path + ".bin", std::ios::binary);
    text << json{{"width", kWidth},        {"height", kHeight},         {"numbers", kNumbers},
                 {"words", words_.size()}, {"kinds", std::move(kinds)}, {"scenes", scenes_}}
                .dump();
    numbers.write(reinterpret_cast<const char*>(words_.data()), std::streamsize(words_.size() * sizeof(words_[0])));
    numbers.write(reinterpret_cast<const char*>(pixels_.data()), std::streamsize(pixels_.size() * sizeof(pixels_[0])));
    return text.flush() && numbers.flush();
  }

 private:
  static void add_camera(json& entry, const Scene& scene) {
    const Camera& c = scene.camera;
    const core::dmat4 eye = view_of(scene).eye_from_world();
    entry["orthographic"] = c.orthographic;
    entry["window"] = {c.left, c.right, c.bottom, c.top, c.near, c.far};
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row) entry["eye_from_world"].push_back(eye[column][row]);
  }

  /// Items as a snapshot packs them, by kind.
  void add_items(json& entry, const Scene& described) {
    core::Scene scene;
    for (std::size_t i = 0; i < described.items.size(); ++i) {
      const Item& item = described.items[i];
      const core::vec3 colour = colour_of(i);
      entry["colours"].push_back({colour.x, colour.y, colour.z});
      const core::MaterialId material = scene.add_material({"colour", colour});
      const core::NodeId node = scene.add_node(scene.root(), "item", item.placed);
      scene.add_primitive(node, item.primitive, {}, material);
      if (item.mesh)
        add_mesh(entry, item, i);
      else if (item.drawn)
        entry["drawn"].push_back(i);
    }
    if (!scene.commit()) std::abort();
    const core::Snapshot snapshot(scene);
    for (const dvec3& origin : snapshot.chunk_origins())
      for (int axis = 0; axis < 3; ++axis) entry["chunk_origins"].push_back(origin[axis]);
    entry["materials"] = {1.0, 0.0, 1.0, 1.0};
    for (const glm::vec4& row : snapshot.materials())
      for (int i = 0; i < 4; ++i) entry["materials"].push_back(row[i]);
    for (core::Slot slot = 0; slot < snapshot.size(); ++slot) pack_item(entry, snapshot, slot);
    for (auto& [kind, words] : packed_) {
      entry["records"][kind] = {words_.size(), words.size()};
      words_.insert(words_.end(), words.begin(), words.end());
    }
    packed_.clear();
  }

  void pack_item(json& entry, const core::Snapshot& snapshot, core::Slot slot) {
    const core::Kind kind = snapshot.kind(slot);
    const core::KindItems& items = snapshot.of_kind(kind);
    const std::size_t i = snapshot.index_in_kind(slot), count = std::size_t(core::parameter_count(kind));
    const std::uint32_t id = core::to_index(snapshot.item(slot));
    std::vector<gpuprims::Texel> texels(std::size_t(gpuprims::texels_per_item(kind)));
    gpuprims::pack(kind, {&items.parameters[i * count], count}, {items.placements[i], id, snapshot.material(slot) + 1},
                   texels);
    const std::string name(gpuscene::name_of(gpuscene::batch_of(kind)));
    for (const gpuprims::Texel& texel : texels) packed_[name].insert(packed_[name].end(), texel.begin(), texel.end());
    entry["items"][name].push_back(id);
  }

  static void add_mesh(json& entry, const Item& item, std::size_t index) {
    const auto& box = std::get<core::Box>(item.primitive);
    json matrix = json::array();
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 4; ++row) matrix.push_back(row < 3 ? item.placed.linear[column][row] : 0.0);
    for (int row = 0; row < 4; ++row) matrix.push_back(row < 3 ? item.placed.origin[row] : 1.0);
    entry["meshes"].push_back({{"size", {box.size_x, box.size_y, box.size_z}}, {"matrix", matrix}, {"item", index}});
  }

  void add_pixels(const Scene& scene) {
    std::vector<tests::Shape> shapes;
    for (std::size_t i = 0; i < scene.items.size(); ++i) {
      const Item& item = scene.items[i];
      if (item.drawn) shapes.push_back({core::ItemId(i), item.placed, item.primitive, nullptr, !item.mesh});
    }
    for (const tests::PixelHits& around : tests::look_at(shapes, view_of(scene), kWidth, kHeight)) {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const tests::RayHit& hit : around.hits_around) {
        if (!hit.hit()) continue;
        low = std::min(low, hit.depth);
        high = std::max(high, hit.depth);
      }
      const tests::RayHit& centre = around.centre();
      const double item = centre.hit() ? double(core::to_index(centre.items.front())) : -1.0;
      for (const double number : {double(around.hits), double(around.smooth), low, high, centre.normal.x,
                                  centre.normal.y, centre.normal.z, item, double(centre.cut)})
        pixels_.push_back(float(number));
    }
  }

  json scenes_ = json::array();
  std::map<std::string, std::vector<std::uint32_t>> packed_;
  std::vector<std::uint32_t> words_;
  std::vector<float> pixels_;
};

using Random = std::mt19937_64;

double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Any kind of solid, of about unit size.
core::Primitive random_solid(Random& random) {
  const auto r = [&](double low, double high) { return float(between(random, low, high)); };
  switch (std::uniform_int_distribution<int>(0, 8)(random)) {
    case 0:
      return core::Pyramid{r(0.2, 1), r(0.2, 1), r(0, 1), r(0, 1), r(-0.4, 0.4), r(-0.4, 0.4), r(0.3, 1.5)};
    case 1:
      return core::Box{r(0.2, 1), r(0.2, 1), r(0.2, 1)};
    case 2:
      return core::RectangularTorus{r(0, 0.5), r(0.6, 1), r(0.1, 0.6), r(0.3, 7)};
    case 3:
      return core::CircularTorus{r(0.4, 0.8), r(0.05, 0.4), r(0.3, 7)};
    case 4:
      return core::EllipticalDish{r(0.3, 0.8), r(0.1, 0.8)};
    case 5:
      return core::SphericalDish{r(0.3, 0.6), r(0.05, 0.9)};
    case 6:
      return core::Snout{r(0, 0.6),    r(0.1, 0.6),  r(0.3, 1.5),  r(-0.4, 0.4), r(-0.4, 0.4),
                         r(-0.2, 0.2), r(-0.2, 0.2), r(-0.2, 0.2), r(-0.2, 0.2)};
    case 7:
      return core::Cylinder{r(0.05, 0.5), r(0.1, 3)};
    default:
      return core::Sphere{r(0.2, 1.2)};
  }
}

/// Turned, sheared, scaled by axes, and mirrored every other time.
Affine random_place(Random& random, const dvec3& centre, double reach) {
  const auto r = [&] { return between(random, -1.0, 1.0); };
  dmat3 linear;
  do {
    linear = dmat3(r(), r(), r(), r(), r(), r(), r(), r(), r());
  } while (std::abs(glm::determinant(linear)) < 0.1);
  for (int i = 0; i < 3; ++i) linear[i] = glm::normalize(linear[i]) * between(random, 0.6, 1.4);
  return {linear, centre + reach * dvec3(r(), r(), r())};
}

/// Half of 24 solids are drawn, and none of `others`, whose records come first.
Scene random_scene(unsigned seed, bool orthographic, const dvec3& centre, int others = 0) {
  Random random(seed);
  Scene scene{"random, seed " + std::to_string(seed), {}, {}};
  for (int i = 0; i < others + 24; ++i)
    scene.items.push_back({random_solid(random), random_place(random, centre, 2.0), random() % 2 == 0 && i >= others});
  const dvec3 eye = centre + dvec3(between(random, -3.0, 3.0), -5.0, between(random, -3.0, 3.0));
  scene.camera = orthographic ? parallel(eye, centre, 5.0) : look(eye, centre);
  return scene;
}

/// Some primitives are boxes that three.js draws as meshes.
Scene scene_with_meshes(unsigned seed, bool orthographic) {
  Scene scene = random_scene(seed, orthographic, {10.0, 20.0, 30.0});
  scene.name = "with meshes, seed " + std::to_string(seed);
  Random random(seed + 1000);
  for (int i = 0; i < 5; ++i) {
    const float size = float(between(random, 0.8, 2.0));
    scene.items.push_back(
        {core::Box{size, size, 0.4f * size}, random_place(random, {10.0, 20.0, 30.0}, 1.5), true, true});
  }
  return scene;
}

void add_kinds(Writer& writer) {
  const float quarter = float(0.5 * std::numbers::pi);
  const struct {
    const char* name;
    core::Primitive primitive;
    dvec3 inside;
  } kinds[] = {
      {"pyramid", core::Pyramid{1.4f, 1.0f, 0.6f, 0.4f, 0.3f, 0.2f, 1.5f}, {0.0, 0.1, -0.2}},
      {"box", core::Box{1.5f, 1.0f, 0.7f}, {0.3, 0.2, 0.1}},
      {"rectangular torus", core::RectangularTorus{0.5f, 1.1f, 0.6f, 3.0f * quarter}, {0.2, 0.8, 0.1}},
      {"circular torus", core::CircularTorus{0.9f, 0.35f, 3.0f * quarter}, {0.2, 0.9, 0.1}},
      {"closed torus", core::CircularTorus{0.9f, 0.35f, 4.0f * quarter}, {0.2, 0.9, 0.1}},
      {"elliptical dish", core::EllipticalDish{1.0f, 0.5f}, {0.1, 0.2, 0.2}},
      {"spherical dish", core::SphericalDish{1.0f, 0.4f}, {0.1, 0.2, 0.2}},
      {"deep dish", core::SphericalDish{0.6f, 1.1f}, {0.1, 0.2, 0.5}},
      {"snout", core::Snout{0.9f, 0.5f, 1.5f, 0.3f, 0.2f, 0.2f, -0.1f, 0.15f, 0.1f}, {0.1, 0.0, 0.1}},
      {"cone", core::Snout{0.9f, 0.0f, 1.6f, 0.2f, 0.0f, 0, 0, 0, 0}, {0.0, 0.1, -0.4}},
      {"cylinder", core::Cylinder{0.7f, 2.0f}, {0.2, 0.1, 0.3}},
      {"sphere", core::Sphere{1.8f}, {0.2, 0.1, 0.3}},
  };
  for (const auto& [name, primitive, inside] : kinds) {
    const std::pair<const char*, Camera> cameras[] = {
        {"from the side", look({4.0, 1.0, 0.5}, {0, 0, 0})},
        {"from below", look({-1.0, -2.0, -3.0}, {0, 0, 0})},
        {"close", look({1.7, 0.9, 0.8}, {0, 0, 0}, 1.3, 0.01, 100.0)},
        {"orthographic", parallel({3.0, 4.0, 2.0}, {0, 0, 0}, 3.5)},
        {"off-axis", off_axis({5.0, 0.0, 1.0}, {0, 0, 0})},
        {"inside", look(inside, inside + dvec3(1.0, 0.7, -0.4), 1.6, 0.01, 100.0)},
        {"inside, orthographic", parallel(inside, inside + dvec3(1.0, 0.7, -0.4), 3.0, 0.01, 100.0)},
        {"cut by the near plane", look({3.0, 1.0, 0.5}, {0, 0, 0}, 1.0, 2.6, 100.0)},
    };
    for (const auto& [from, camera] : cameras) writer.add({std::string(name) + ", " + from, {{primitive}}, camera});
    writer.add({std::string(name) + ", inside a large one",
                {{primitive, {dmat3(30.0), {0.0, 0.0, 0.0}}}},
                look(30.0 * inside, 30.0 * inside + dvec3(1.0, 0.7, -0.4), 1.6, 3.0, 500.0)});
    Scene cut{std::string(name) + ", sections", {{primitive}}, look({4.0, 1.0, 2.0}, {0, 0, 0})};
    cut.sections = {{{-1.0, 0.0, 0.0}, 0.1}, {{0.0, -0.5, -1.0}, 0.3}};
    writer.add(cut);
    cut.name += " united";
    cut.unite = true;
    writer.add(cut);
  }
}

/// Pipes beside the eye and behind it, of which the near plane cuts the boxes, and thin ones that are far away.
void add_pipes(Writer& writer) {
  const auto along = [](const dvec3& from, const dvec3& to, double radius) {
    const dvec3 axis = glm::normalize(to - from), side = glm::normalize(glm::cross(axis, dvec3(0.3, 0.2, 0.9)));
    return Item{core::Cylinder{float(radius), float(glm::length(to - from))},
                {dmat3(side, glm::cross(axis, side), axis), 0.5 * (from + to)}};
  };
  Scene rack{"pipes beside the eye", {}, look({0, 0, 0}, {1, 0, 0}, 1.3, 0.1, 200.0)};
  for (int i = 0; i < 6; ++i) {
    const double turn = core::kFullTurn * i / 6.0;
    const dvec3 aside(0.0, 0.6 * std::cos(turn), 0.6 * std::sin(turn));
    rack.items.push_back(along(aside + dvec3(-30, 0, 0), aside + dvec3(50, 0, 0), 0.1 + 0.02 * i));
  }
  rack.items.push_back(along({10, -5, -5}, {10, 5, 5}, 0.3));
  rack.items.push_back(along({-10, -5, -5}, {-10, 5, 5}, 0.3));
  writer.add(rack);

  // The farther, the more than float's 24 bits count.
  for (const double distance : {2e3, 5e5}) {
    const dvec3 site(4.0e6 + 0.1234567, -7.0e6 - 0.7654321, 250.0112358),
        direction = glm::normalize(dvec3(1.0, 0.2, 0.3));
    Scene far{"thin pipes from afar, " + std::to_string(distance),
              {},
              look(site, site + direction, 8.0 / distance, 0.5 * distance, 2.0 * distance)};
    Random random(7);
    for (int i = 0; i < 8; ++i) {
      const auto r = [&] { return between(random, -3.0, 3.0); };
      const dvec3 centre = site + distance * direction + dvec3(r(), r(), r()), half(r(), r(), r());
      far.items.push_back(along(centre - half, centre + half, between(random, 0.05, 0.3)));
    }
    writer.add(far);
    far.name += ", off-axis";
    far.camera = aside(far.camera, direction);
    writer.add(far);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "wasm_primitives_scenes: expected the path of the files to write\n");
    return 2;
  }
  Writer writer;
  add_kinds(writer);
  for (unsigned seed = 1; seed <= 6; ++seed) writer.add(random_scene(seed, seed > 3, {1.0, 2.0, 3.0}));
  for (unsigned seed = 7; seed <= 10; ++seed) writer.add(random_scene(seed, seed > 8, {5.0e6, -3.0e6, 4.0e4}));
  writer.add(random_scene(15, false, {1.0, 2.0, 3.0}, 6000));  // records fill several rows of a texture
  for (unsigned seed = 11; seed <= 14; ++seed) writer.add(scene_with_meshes(seed, seed > 12));
  add_pipes(writer);
  if (writer.write(argv[1])) return 0;
  std::fprintf(stderr, "wasm_primitives_scenes: cannot write %s.json and %s.bin\n", argv[1], argv[1]);
  return 1;
}
