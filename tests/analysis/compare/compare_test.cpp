// compare against a twin that looks at all pairs, and cases made by hand.
#include "sightline/analysis/compare/compare.h"

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/tests/core/primitive_samples.h"

namespace sightline::tests::compare_test {
namespace {

using compare::Change;
using compare::Comparison;
using compare::State;
using core::Affine;
using core::dvec3;
using core::Kind;
using core::Primitive;

constexpr double kTolerance = 1e-4;

Comparison compared(const core::Scene& before, const core::Scene& after, double tolerance = kTolerance) {
  return compare::revisions({&before, before.root()}, {&after, after.root()}, {tolerance}).value();
}

// --- random edits against the twin -----------------------------------------------------------------------------------

/// A tetrahedron without symmetry. Its vertices may come turned, as an importer's shared meshes do.
core::Mesh tetrahedron(float size, const Affine& turned = {}) {
  core::Mesh mesh;
  for (const dvec3& p : {dvec3(0, 0, 0), dvec3(1, 0, 0), dvec3(0, 0.7, 0), dvec3(0.1, 0.2, 0.5)})
    mesh.positions.emplace_back(core::transform_point(turned, double(size) * p));
  mesh.indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  return mesh;
}

const std::vector<Primitive>& primitives() {
  static const std::vector<Primitive> all = {core::Box{1, 2, 3},
                                             core::Box{1, 2, 3.01f},
                                             core::Cylinder{0.5f, 2},
                                             core::Cylinder{0.5f, 2.5f},
                                             core::Sphere{1},
                                             core::Pyramid{1, 2, 0.5f, 0.7f, 0.1f, 0.2f, 1},
                                             core::Line{-1, 1},
                                             core::CircularTorus{1, 0.2f, 1},
                                             core::RectangularTorus{1, 1.5f, 0.4f, 2},
                                             core::Snout{1, 0.5f, 1, 0, 0, 0, 0, 0, 0},
                                             core::EllipticalDish{1, 0.5f},
                                             core::SphericalDish{1, 0.5f}};
  return all;
}
constexpr int kMeshes = 2;
const int kShapes = int(primitives().size()) + kMeshes;

/// An item of the model that scenes are made of: its shape and place are known, not found.
struct Piece {
  int shape = 0, material = 0;
  Affine world;
};
struct Branch {
  std::string name;
  std::map<std::string, std::string> attributes;
  std::vector<Piece> pieces;
  std::vector<Branch> children;
};

std::string random_name(Random& random, bool names) {
  return names ? "node" + std::to_string(random()) : std::string(random() % 3, 'a');
}

Affine random_place(Random& random, const dvec3& site) {
  return {random_rotation(random),
          site + dvec3(uniform(random, -9, 9), uniform(random, -9, 9), uniform(random, -9, 9))};
}

struct Settings {
  bool unique_names, equal_shapes, few_places;
  dvec3 site;
};

Piece random_piece(Random& random, const Settings& s) {
  Piece piece{s.equal_shapes ? 2 : int(random() % std::uint64_t(kShapes)), int(random() % 3), {}};
  Random places(s.few_places ? random() % 3 : random());
  piece.world = random_place(places, s.site);
  return piece;
}

Branch random_branch(Random& random, const Settings& s, int depth) {
  Branch branch{random_name(random, s.unique_names), {}, {}, {}};
  if (random() % 2) branch.attributes["Type"] = std::to_string(random() % 3);
  for (auto n = random() % 4; n > 0; --n) branch.pieces.push_back(random_piece(random, s));
  for (auto n = depth == 0 ? 0 : random() % 4; n > 0; --n)
    branch.children.push_back(random_branch(random, s, depth - 1));
  return branch;
}

void list(Branch& branch, std::vector<Branch*>& out) {
  out.push_back(&branch);
  for (Branch& child : branch.children) list(child, out);
}

void edit_node(Branch& root, Random& random, const Settings& s) {
  std::vector<Branch*> all;
  list(root, all);
  Branch& branch = *all[random() % all.size()];
  switch (random() % 6) {
    case 0:
      if (&branch != &root) branch.name = random_name(random, s.unique_names);
      break;
    case 1:
      branch.attributes["Type"] = std::to_string(random() % 3);
      break;
    case 2:
      branch.children.push_back(random_branch(random, s, 1));
      break;
    case 3:
      if (!branch.children.empty()) branch.children.erase(branch.children.begin());
      break;
    case 4:
      std::reverse(branch.children.begin(), branch.children.end());
      break;
    default:  // reparents a child to the root
      if (&branch == &root || branch.children.empty()) break;
      Branch child = std::move(branch.children.back());
      branch.children.pop_back();
      root.children.push_back(std::move(child));
  }
}

void edit_piece(Branch& root, Random& random, const Settings& s) {
  std::vector<Branch*> all;
  list(root, all);
  Branch& branch = *all[random() % all.size()];
  if (branch.pieces.empty()) return;
  Piece& piece = branch.pieces[random() % branch.pieces.size()];
  switch (random() % 7) {
    case 0:
      piece.world.origin += uniform(random, 0.01, 1.0) * random_direction(random);
      break;
    case 1:
      piece.world.origin += 0.2 * kTolerance * random_direction(random);  // within the tolerance
      break;
    case 2:
      piece.world = random_place(random, s.site);
      break;
    case 3:
      piece.shape = int(random() % std::uint64_t(kShapes));
      break;
    case 4:
      piece.material = int(random() % 3);
      break;
    case 5:
      branch.pieces.erase(branch.pieces.begin() + (&piece - branch.pieces.data()));
      break;
    default:
      branch.pieces.insert(branch.pieces.begin(), random_piece(random, s));
  }
}

/// A piece as the twin sees it. Its number is its item's id.
struct Listed {
  Piece piece;
  std::vector<std::string> path;
  std::vector<std::pair<std::string, int>> ordered_path;
  int order = 0;
  std::map<std::string, std::string> attributes;

  std::vector<std::string> parent_path() const {
    return path.empty() ? path : std::vector<std::string>(path.begin(), path.end() - 1);
  }
};

Affine inverse(const Affine& a) {
  const core::dmat3 linear = glm::inverse(a.linear);
  return {linear, -(linear * a.origin)};
}

/// Makes the scene of a model, with placements shared out between nodes and items at random, some in millimetres.
class Builder {
 public:
  explicit Builder(Random& random) : random_(random) {
    for (int i = 0; i < 3; ++i) materials_.push_back(scene.add_material({"m" + std::to_string(i), {}, 1.0f, 0}));
    for (int i = 0; i < kMeshes; ++i) {
      turned_.push_back({random_rotation(random), random_direction(random)});
      meshes_.push_back(*scene.add_mesh(tetrahedron(float(i + 1), turned_.back())));
    }
  }

  void build(const Branch& root) {
    for (const auto& [key, value] : root.attributes) scene.set_attribute(scene.root(), key, value);
    fill(root, scene.root(), {}, {}, {});
  }

  core::Scene scene;
  std::vector<Listed> listed;

 private:
  void fill(const Branch& branch, core::NodeId node, const Affine& world, std::vector<std::string> path,
            std::vector<std::pair<std::string, int>> ordered) {
    for (int i = 0; i < int(branch.pieces.size()); ++i) {
      const Piece& piece = branch.pieces[std::size_t(i)];
      add(piece, node, inverse(world) * piece.world);
      listed.push_back({piece, path, ordered, i, branch.attributes});
    }
    std::map<std::string, int> equal;
    for (const Branch& child : branch.children) {
      const Affine local{random_rotation(random_), 10.0 * random_direction(random_)};
      const core::NodeId below = scene.add_node(node, child.name, local);
      for (const auto& [key, value] : child.attributes) scene.set_attribute(below, key, value);
      path.push_back(child.name);
      ordered.emplace_back(child.name, equal[child.name]++);
      fill(child, below, world * local, path, ordered);
      path.pop_back();
      ordered.pop_back();
    }
  }

  void add(const Piece& piece, core::NodeId node, Affine placement) {
    const core::MaterialId material = materials_[std::size_t(piece.material)];
    const int mesh = piece.shape - int(primitives().size());
    if (mesh >= 0) {
      scene.add_mesh_instance(node, meshes_[std::size_t(mesh)], placement * inverse(turned_[std::size_t(mesh)]),
                              material);
      return;
    }
    Primitive primitive = primitives()[std::size_t(piece.shape)];
    const bool scalable =
        std::holds_alternative<core::Box>(primitive) || std::holds_alternative<core::Cylinder>(primitive);
    if (scalable && random_() % 2) {
      std::vector<float> values(core::parameters(primitive).begin(), core::parameters(primitive).end());
      for (float& value : values) value *= 1000.0f;
      primitive = core::make_primitive(core::kind_of(primitive), values);
      placement.linear *= 1e-3;
    }
    scene.add_primitive(node, primitive, placement, material);
  }

  Random& random_;
  std::vector<core::MaterialId> materials_;
  std::vector<core::MeshId> meshes_;
  std::vector<Affine> turned_;
};

bool same_place(const Listed& a, const Listed& b) {
  return glm::length(a.piece.world.origin - b.piece.world.origin) < kTolerance;
}

/// The four steps as compare.h states them, over all pairs. Returns the partner of each of `after`, or -1.
std::vector<int> twin(const std::vector<Listed>& before, const std::vector<Listed>& after) {
  std::vector<int> partner(after.size(), -1);
  std::vector<bool> taken(before.size(), false);
  const auto step = [&](const auto& fits) {
    for (std::size_t j = 0; j < after.size(); ++j)
      for (std::size_t i = 0; i < before.size() && partner[j] < 0; ++i)
        if (!taken[i] && fits(before[i], after[j])) taken[i] = true, partner[j] = int(i);
  };
  const auto alike = [](const Listed& a, const Listed& b) {
    return a.piece.shape == b.piece.shape && same_place(a, b);
  };
  step([&](const Listed& a, const Listed& b) { return a.path == b.path && alike(a, b); });
  step([](const Listed& a, const Listed& b) { return a.ordered_path == b.ordered_path && a.order == b.order; });
  step(alike);
  step([](const Listed& a, const Listed& b) {
    return a.parent_path() == b.parent_path() && a.piece.shape == b.piece.shape;
  });
  return partner;
}

void expect_pair(const Change& change, const Listed& a, const Listed& b, bool with_attributes) {
  const bool other_attributes = with_attributes && a.attributes != b.attributes;
  EXPECT_EQ(bool(change.differences & compare::kShape), a.piece.shape != b.piece.shape);
  EXPECT_EQ(bool(change.differences & compare::kMaterial), a.piece.material != b.piece.material);
  EXPECT_EQ(bool(change.differences & compare::kAttributes), other_attributes);
  EXPECT_EQ(bool(change.differences & compare::kPath), a.path != b.path);
  const bool changed = a.piece.shape != b.piece.shape || a.piece.material != b.piece.material || other_attributes;
  if (a.piece.shape == b.piece.shape) {
    EXPECT_EQ(bool(change.differences & compare::kPlace), !same_place(a, b));
  }
  EXPECT_EQ(change.state, changed ? State::kChanged : same_place(a, b) ? State::kUnchanged : State::kMoved);
}

void expect_like_twin(const Comparison& found, const std::vector<Listed>& before, const std::vector<Listed>& after) {
  const std::vector<int> partner = twin(before, after);
  const auto any = [](const std::vector<Listed>& side) {
    return std::any_of(side.begin(), side.end(), [](const Listed& one) { return !one.attributes.empty(); });
  };
  EXPECT_EQ(found.with_attributes, any(before) == any(after));
  std::vector<bool> taken(before.size(), false);
  ASSERT_GE(found.items.size(), after.size());
  for (std::size_t j = 0; j < after.size(); ++j) {
    const Change& change = found.items[j];
    SCOPED_TRACE("item " + std::to_string(j));
    ASSERT_EQ(to_index(change.after), j);
    ASSERT_EQ(change.before, partner[j] < 0 ? core::kNoItem : core::ItemId(partner[j]));
    if (partner[j] < 0) {
      EXPECT_EQ(change.state, State::kAdded);
      EXPECT_EQ(change.differences, 0);
      continue;
    }
    taken[std::size_t(partner[j])] = true;
    expect_pair(change, before[std::size_t(partner[j])], after[j], found.with_attributes);
  }
  std::size_t at = after.size();
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (taken[i]) continue;
    ASSERT_LT(at, found.items.size());
    EXPECT_EQ(to_index(found.items[at].before), i);
    EXPECT_EQ(found.items[at].after, core::kNoItem);
    EXPECT_EQ(found.items[at++].state, State::kRemoved);
  }
  EXPECT_EQ(at, found.items.size());
}

void compare_random_models(const Settings& settings) {
  std::size_t seen[compare::kStateCount] = {}, renamed = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Branch model = random_branch(random, settings, 3);
    Builder before(random), after(random);
    before.build(model);
    for (auto n = random() % 12; n > 0; --n) {
      if (random() % 3 == 0)
        edit_node(model, random, settings);
      else
        edit_piece(model, random, settings);
    }
    after.build(model);
    const Comparison found = compared(before.scene, after.scene);
    expect_like_twin(found, before.listed, after.listed);
    if (::testing::Test::HasFailure()) return;
    for (std::size_t i = 0; i < compare::kStateCount; ++i) seen[i] += found.counts[i];
    renamed += found.renamed;
  }
  for (const std::size_t count : seen) EXPECT_GT(count, 100u);
  EXPECT_GT(renamed, 100u);
}

TEST(Compare, FindsWhatTheTwinFinds) {
  compare_random_models({true, false, false, dvec3(0.0)});
}
TEST(Compare, FindsWhatTheTwinFindsAmongEqualNames) {
  compare_random_models({false, false, false, dvec3(0.0)});
}
TEST(Compare, FindsWhatTheTwinFindsAmongEqualShapesInFewPlaces) {
  compare_random_models({false, true, true, dvec3(0.0)});
}
TEST(Compare, FindsWhatTheTwinFindsFarFromTheOrigin) {
  compare_random_models({false, false, false, dvec3(3e6, -7e6, 1e5)});
}

// --- geometry --------------------------------------------------------------------------------------------------------

core::Scene scene_of(const Primitive& primitive, const Affine& place) {
  core::Scene scene;
  scene.add_primitive(scene.add_node(scene.root(), "part"), primitive, place);
  return scene;
}

core::Scene scene_of(const core::Mesh& mesh, const Affine& place) {
  core::Scene scene;
  const core::MeshId id = *scene.add_mesh(mesh);
  scene.add_mesh_instance(scene.add_node(scene.root(), "part"), id, place);
  return scene;
}

template <class A, class B>
Change change_of(const A& a, const Affine& at_a, const B& b, const Affine& at_b) {
  const Comparison found = compared(scene_of(a, at_a), scene_of(b, at_b));
  return found.items.at(0);
}

TEST(Compare, KeepsToTheTolerance) {
  Random random(7);
  for (int trial = 0; trial < 2000; ++trial) {
    const Primitive& primitive = primitives()[random() % primitives().size()];
    const Affine place = random_place(random, 1e6 * random_direction(random));
    SCOPED_TRACE("seed 7, trial " + std::to_string(trial) + ", " + std::string(name_of(core::kind_of(primitive))));
    for (const auto& [factor, state] : {std::pair(0.9, State::kUnchanged), std::pair(1.2, State::kMoved)}) {
      const dvec3 offset = factor * kTolerance * random_direction(random);
      const Change change = change_of(primitive, place, primitive, {place.linear, place.origin + offset});
      EXPECT_EQ(change.state, state);
      if (state == State::kMoved) {
        EXPECT_LT(glm::length(change.offset - offset), 1e-8);
        EXPECT_LT(change.turn, 1e-6);
      }
    }
  }
}

TEST(Compare, TellsByHowMuchAnItemMovedAndTurned) {
  Random random(8);
  for (int trial = 0; trial < 500; ++trial) {
    SCOPED_TRACE("seed 8, trial " + std::to_string(trial));
    const double angle = uniform(random, 0.1, 3.1);
    const core::dmat3 frame = random_rotation(random);
    const core::dmat3 spin{{std::cos(angle), std::sin(angle), 0}, {-std::sin(angle), std::cos(angle), 0}, {0, 0, 1}};
    const core::dmat3 turn = frame * spin * glm::transpose(frame);
    const Affine place = random_place(random, dvec3(0.0));
    const dvec3 offset = random_direction(random);
    const Change change =
        change_of(core::Box{1, 2, 3}, place, core::Box{1, 2, 3}, {turn * place.linear, place.origin + offset});
    EXPECT_EQ(change.state, State::kMoved);
    EXPECT_NEAR(change.turn, angle, 1e-6);
    EXPECT_LT(glm::length(change.offset - offset), 1e-9);
    const Change mesh = change_of(tetrahedron(1), place, tetrahedron(1), {turn * place.linear, place.origin + offset});
    EXPECT_EQ(mesh.state, State::kMoved);
    EXPECT_NEAR(mesh.turn, angle, 1e-6);
  }
}

TEST(Compare, ATurnThatASolidDoesNotShowIsNoMove) {
  Random random(9);
  const core::dmat3 quarter{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, over{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE("seed 9, trial " + std::to_string(trial));
    const Affine place = random_place(random, dvec3(1e5));
    const auto state = [&](const Primitive& p, const core::dmat3& turn) {
      return change_of(p, place, p, {place.linear * turn, place.origin}).state;
    };
    EXPECT_EQ(state(core::Sphere{2}, random_rotation(random)), State::kUnchanged);
    EXPECT_EQ(state(core::Cylinder{1, 5}, quarter), State::kUnchanged);
    EXPECT_EQ(state(core::Cylinder{1, 5}, over), State::kUnchanged);
    EXPECT_EQ(state(core::CircularTorus{2, 0.5f, 6.2831855f}, quarter), State::kUnchanged);
    EXPECT_EQ(state(core::CircularTorus{2, 0.5f, 1.0f}, quarter), State::kMoved);
    EXPECT_EQ(state(core::EllipticalDish{1, 0.5f}, over), State::kMoved);
    EXPECT_EQ(state(core::Box{2, 2, 3}, quarter), State::kUnchanged);
    EXPECT_EQ(state(core::Box{2, 2.001f, 3}, quarter), State::kMoved);
    EXPECT_EQ(state(core::Snout{1, 0.5f, 2, 0, 0, 0, 0, 0, 0}, quarter), State::kUnchanged);
    EXPECT_EQ(state(core::Snout{1, 0.5f, 2, 0.2f, 0, 0, 0, 0, 0}, quarter), State::kMoved);
  }
}

TEST(Compare, OtherUnitsAreNoChange) {
  const Affine millimetres{core::dmat3(1e-3), dvec3(5, 6, 7)}, metres{core::dmat3(1.0), dvec3(5, 6, 7)};
  EXPECT_EQ(change_of(core::Cylinder{0.2f, 3}, metres, core::Cylinder{200, 3000}, millimetres).state,
            State::kUnchanged);
  EXPECT_EQ(
      change_of(core::CircularTorus{1, 0.2f, 1.5f}, metres, core::CircularTorus{1000, 200, 1.5f}, millimetres).state,
      State::kUnchanged);
  EXPECT_EQ(
      change_of(core::Cylinder{0.2f, 3}, metres, core::Cylinder{0.2f, 3}, {core::dmat3(1.01), metres.origin}).state,
      State::kChanged);
  EXPECT_EQ(change_of(tetrahedron(1), metres, tetrahedron(1000), millimetres).state, State::kUnchanged);
}

TEST(Compare, ParametersInsideTheHullCount) {
  const Change change =
      change_of(core::RectangularTorus{1, 2, 1, 6.2831855f}, {}, core::RectangularTorus{1.1f, 2, 1, 6.2831855f}, {});
  EXPECT_EQ(change.state, State::kChanged);
  EXPECT_EQ(change.differences, compare::kShape);
}

TEST(Compare, MeshesAreComparedInTheWorld) {
  Random random(10);
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE("seed 10, trial " + std::to_string(trial));
    const Affine place = random_place(random, dvec3(1e6)), turned{random_rotation(random), random_direction(random)};
    EXPECT_EQ(change_of(tetrahedron(1), place, tetrahedron(1, turned), place * inverse(turned)).state,
              State::kUnchanged);
    core::Affine mirrored = place;
    mirrored.linear[0] = -mirrored.linear[0];
    EXPECT_EQ(change_of(tetrahedron(1), place, tetrahedron(1), mirrored).differences & compare::kShape,
              compare::kShape);
    core::Mesh bent = tetrahedron(1);
    bent.positions[3].x += 0.001f;
    EXPECT_EQ(change_of(tetrahedron(1), place, bent, place).state, State::kChanged);
    core::Mesh fewer = tetrahedron(1);
    fewer.indices.resize(9);
    EXPECT_EQ(change_of(tetrahedron(1), place, fewer, place).state, State::kChanged);
  }
}

// --- by hand ---------------------------------------------------------------------------------------------------------

TEST(Compare, EmptyScenes) {
  core::Scene empty, one = scene_of(core::Sphere{1}, {});
  EXPECT_TRUE(compared(empty, empty).items.empty());
  EXPECT_TRUE(compared(empty, empty).same());
  EXPECT_EQ(compared(empty, one).count(State::kAdded), 1u);
  EXPECT_EQ(compared(one, empty).count(State::kRemoved), 1u);
  EXPECT_FALSE(compared(one, empty).same());
  EXPECT_TRUE(compared(one, one).same());
}

TEST(Compare, EmptyMeshesAndSolidsOfNoSize) {
  EXPECT_EQ(change_of(core::Mesh{}, {}, core::Mesh{}, {}).state, State::kUnchanged);
  EXPECT_EQ(change_of(core::Mesh{}, {}, core::Mesh{}, core::translation({1, 0, 0})).state, State::kMoved);
  EXPECT_EQ(change_of(core::Sphere{0}, {}, core::Sphere{0}, {}).state, State::kUnchanged);
  const Affine flat{core::dmat3(0.0), dvec3(1.0)};
  EXPECT_EQ(change_of(core::Box{1, 1, 1}, flat, core::Box{1, 1, 1}, flat).state, State::kUnchanged);
  EXPECT_EQ(change_of(tetrahedron(1), flat, tetrahedron(1), flat).state, State::kUnchanged);
}

TEST(Compare, DuplicatesInOnePlaceAreCounted) {
  core::Scene three, five;
  for (int i = 0; i < 3; ++i) three.add_primitive(three.root(), core::Sphere{1});
  for (int i = 0; i < 5; ++i) five.add_primitive(five.root(), core::Sphere{1});
  EXPECT_EQ(compared(three, five).count(State::kUnchanged), 3u);
  EXPECT_EQ(compared(three, five).count(State::kAdded), 2u);
  EXPECT_EQ(compared(five, three).count(State::kRemoved), 2u);
}

TEST(Compare, ManyShapesInOnePlaceTakeNoQuadraticTime) {
  core::Scene before, after;
  constexpr int kCount = 100'000;  // pairs of these would take an hour
  for (int i = 0; i < kCount; ++i) {
    before.add_primitive(before.root(), core::Box{1, 2, 1});
    after.add_primitive(after.add_node(after.root(), std::to_string(i)), core::Box{2, 1, 1});
  }
  const Comparison found = compared(before, after);
  EXPECT_EQ(found.count(State::kAdded), std::size_t(kCount));
  EXPECT_EQ(found.count(State::kRemoved), std::size_t(kCount));
}

TEST(Compare, AFrameOfAnotherNameIsRenamedNotAddedAndRemoved) {
  core::Scene before, after;
  const auto fill = [](core::Scene& scene, const char* name) {
    const core::NodeId frame = scene.add_node(scene.root(), name);
    for (int i = 0; i < 10; ++i)
      scene.add_primitive(scene.add_node(frame, "part " + std::to_string(i)), core::Sphere{1},
                          core::translation({3.0 * i, 0, 0}));
  };
  fill(before, "/PIPE-1");
  fill(after, "/PIPE-1-REV-B");
  const Comparison found = compared(before, after);
  EXPECT_EQ(found.count(State::kUnchanged), 10u);
  EXPECT_EQ(found.renamed, 10u);
  EXPECT_TRUE(found.same());
}

TEST(Compare, MaterialsAndAttributesAreThoseOfTheWholeChain) {
  core::Scene before = scene_of(core::Sphere{1}, {}), after = scene_of(core::Sphere{1}, {});
  const auto part = [](const core::Scene& scene) { return scene.first_child(scene.root()); };
  after.set_material(after.root(), after.add_material({"steel", {0.5f, 0.5f, 0.5f}, 1.0f, 0}));
  EXPECT_EQ(compared(before, after).items[0].differences, compare::kMaterial);
  before.set_material(part(before), before.add_material({"steel", {0.5f, 0.5f, 0.5f}, 1.0f, 7}));
  EXPECT_TRUE(compared(before, after).same());
  before.set_attribute(part(before), "A", "1");
  before.set_attribute(part(before), "B", "2");
  after.set_attribute(part(after), "B", "2");
  EXPECT_EQ(compared(before, after).items[0].differences, compare::kAttributes);
  after.set_attribute(part(after), "A", "1");
  EXPECT_TRUE(compared(before, after).same());
  after.set_attribute(after.root(), "Revision", "B");
  const Comparison found = compared(before, after);
  EXPECT_EQ(found.count(State::kUnchanged), 1u);
  ASSERT_EQ(found.nodes.size(), 1u);
  EXPECT_EQ(found.nodes[0].after, after.root());
  EXPECT_FALSE(found.same());
}

/// A file of a format that holds no attributes, or read without their file.
TEST(Compare, ARevisionWithoutAttributesDiffersInNone) {
  core::Scene before = scene_of(core::Sphere{1}, {}), after = scene_of(core::Sphere{1}, {});
  before.set_attribute(before.root(), "rvm.date", "1");  // of the file, not of what it holds
  after.set_attribute(after.first_child(after.root()), "A", "1");
  const Comparison found = compared(before, after);
  EXPECT_TRUE(found.same());
  EXPECT_FALSE(found.with_attributes);
  before.set_attribute(before.first_child(before.root()), "A", "2");
  EXPECT_TRUE(compared(before, after).with_attributes);
  EXPECT_FALSE(compared(before, after).same());
}

TEST(Compare, SubtreesAndHiddenItemsTakePart) {
  core::Scene scene;
  const core::NodeId a = scene.add_node(scene.root(), "old.rvm"), b = scene.add_node(scene.root(), "new.rvm");
  scene.add_primitive(scene.add_node(a, "part"), core::Sphere{1});
  const core::NodeId part = scene.add_node(b, "part");
  scene.add_primitive(part, core::Sphere{1});
  scene.set_visible(part, false);
  const auto found = compare::revisions({&scene, a}, {&scene, b});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->items.size(), 1u);
  EXPECT_TRUE(found->same());
  EXPECT_EQ(found->renamed, 0u);
}

TEST(Compare, RefusesTolerancesOutOfRange) {
  const core::Scene scene;
  for (const double bad : {-1.0, double(NAN), double(INFINITY)}) {
    const auto found = compare::revisions({&scene, scene.root()}, {&scene, scene.root()}, {bad});
    ASSERT_FALSE(found);
    EXPECT_NE(found.error().message.find("tolerance"), std::string::npos);
  }
  const core::Scene one = scene_of(core::Sphere{1}, core::translation({1e6, 2, 3}));
  EXPECT_TRUE(compared(one, one, 0.0).same());
}

/// Progress rises from 0 to 1 at most, and whenever it says stop the comparison ends at once, cancelled.
TEST(Compare, TellsProgressAndCanBeCancelled) {
  core::Scene before, after;
  for (int i = 0; i < 9000; ++i) {
    before.add_primitive(before.root(), core::Sphere{1}, core::translation({i, 0, 0}));
    after.add_primitive(after.root(), core::Sphere{i % 2 ? 1.0f : 2.0f}, core::translation({i, 0.5 * (i % 3), 0}));
  }
  const auto compared = [&](const std::function<bool(double)>& progress) {
    return compare::revisions({&before, before.root()}, {&after, after.root()}, {.progress = progress});
  };
  std::vector<double> shares;
  ASSERT_TRUE(compared([&](double share) { return shares.push_back(share), true; }));
  ASSERT_GT(shares.size(), 10u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GE(shares.front(), 0.0);
  EXPECT_LE(shares.back(), 1.0);
  for (std::size_t stop = 0; stop < shares.size(); ++stop) {
    std::size_t calls = 0;
    const auto found = compared([&](double) { return calls++ < stop; });
    ASSERT_FALSE(found) << stop;
    EXPECT_EQ(found.error().message, compare::kCancelled);
    EXPECT_EQ(calls, stop + 1) << "asked again after the end";
  }
}

}  // namespace
}  // namespace sightline::tests::compare_test
