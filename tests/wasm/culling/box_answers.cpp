#include "box_answers.h"

#include <limits>

#include "recorded_view.h"
#include "sightline/bindings/wasm/visibility.h"
#include "sightline/culling/box_culler.h"
#include "sightline/culling/occlusion/occluder_raster.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/culling/queries/spatial_queries.h"
#include "sightline/tests/culling/box_view_pairs.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests {
namespace {

using core::AabbD;
using core::dvec3;
using Indices = std::vector<std::uint32_t>;

/// A culler, a view and occluders here and, by what it records, there.
class Both {
 public:
  explicit Both(RecordWriter& out) : out_(&out) {}

  void begin(const char* family, std::uint64_t seed) {
    out_->text("case");
    out_->text(std::string(family) + ", seed " + std::to_string(seed));
  }

  void create(std::vector<AabbD> boxes) {
    boxes_ = std::move(boxes);
    out_->text("create");
    out_->array(numbers_of(boxes_));
    auto culler = culling::BoxCuller::create(boxes_);
    out_->text(culler ? "" : culler.error().message);
    if (culler) culler_ = std::make_unique<culling::BoxCuller>(std::move(*culler));
  }
  void update(const Indices& indices, const std::vector<AabbD>& boxes) {
    out_->text("update");
    out_->array(indices);
    out_->array(numbers_of(boxes));
    const auto done = culler_->update(indices, boxes);
    out_->text(done ? "" : done.error().message);
    if (!done) return;
    for (std::size_t i = 0; i < indices.size(); ++i) boxes_[indices[i]] = boxes[i];
  }
  void refit(const std::vector<AabbD>& boxes) {
    out_->text("refit");
    out_->array(numbers_of(boxes));
    const auto done = culler_->refit(boxes);
    out_->text(done ? "" : done.error().message);
    if (done) boxes_ = boxes;
  }

  void look(const core::View& view, int width, int height, bool zero_to_one = false) {
    if (zero_to_one && view.clip_depth() == core::ClipDepth::kReversedZeroToOne) {
      core::View turned = *core::View::from_matrices(view.eye_from_world(), turned_depth(view.clip_from_eye()),
                                                     core::ClipDepth::kZeroToOne);
      turned.sections = view.sections;
      turned.section_mode = view.section_mode;
      return look(turned, width, height);
    }
    out_->text("view");
    write_view(*out_, view, width, height);
    view_.emplace(wasm::ViewObject{view, width, height});
  }
  void visible() {
    out_->text("visible");
    culler_->visible(view_->view, indices_);
    out_->array(indices_);
  }
  void visible_in() {
    const core::dmat4 clip = view_->view.clip_from_world();
    out_->text("visibleIn");
    out_->array(numbers_of(clip));
    out_->numbers({double(view_->view.clip_depth())});
    const auto done = culler_->visible(glm::value_ptr(clip), view_->view.clip_depth(), indices_);
    if (!done) indices_.clear();
    out_->array(indices_);
  }
  /// Behind the pyramid, and larger than an area, if it is not 0.
  void visible_within(bool behind, float least_area) {
    out_->text("visibleWithin");
    out_->numbers({behind ? 1.0 : 0.0, double(least_area)});
    if (behind && least_area <= 0.0f) {
      culler_->visible(view_->view, pyramid_, indices_);
    } else {
      core::VisibleSet set;
      wasm::find_visible(culler_->bounds(), culler_->culler(), *view_, {behind ? &pyramid_ : nullptr, least_area},
                         nullptr, set);
      list(set);
    }
    out_->array(indices_);
  }

  // --- occluders

  void begin_raster() {
    out_->text("raster");
    raster_.begin(view_->view, view_->width, view_->height);
  }
  void add_boxes(const std::vector<AabbD>& boxes) {
    std::uint32_t added = 0;
    for (const AabbD& box : boxes) added += raster_.add_box(box);
    record_added("addBoxes", boxes, added, 0);
  }
  void add_largest(const std::vector<AabbD>& boxes, std::uint32_t most) {
    record_added("addLargest", boxes, std::uint32_t(raster_.add_largest(boxes, most)), most);
  }
  void add_placed(const core::Affine& placement, int sides) {
    core::dmat4 matrix(placement.linear);
    matrix[3] = core::dvec4(placement.origin, 1.0);
    out_->text("addPlaced");
    out_->array(numbers_of(matrix));
    const bool added = sides == 0 ? raster_.add_cube(placement) : raster_.add_cylinder(placement, sides);
    out_->numbers({double(sides), added ? 1.0 : 0.0});
  }
  void add_mesh(const std::vector<core::vec3>& positions, const Indices& corners, const dvec3& origin) {
    out_->text("addMesh");
    out_->array(std::span(&positions[0].x, 3 * positions.size()));
    out_->array(corners);
    core::dmat4 matrix(1.0);
    matrix[3] = core::dvec4(origin, 1.0);
    out_->array(numbers_of(matrix));
    raster_.add_mesh(positions, corners, core::translation(origin));
  }
  void build() {
    out_->text("build");
    std::vector<float> distances(std::size_t(view_->width) * std::size_t(view_->height));
    raster_.distances(distances);
    out_->array(distances);
    raster_.build(pyramid_);
  }
  void build_from(const std::vector<float>& distances) {
    out_->text("pyramid");
    out_->array(distances);
    pyramid_.build(distances, view_->width, view_->height);
  }
  void hides(const std::vector<AabbD>& boxes) {
    out_->text("hides");
    out_->array(numbers_of(boxes));
    AabbD all;
    for (const AabbD& box : boxes)
      if (!box.empty()) all.grow(box);
    const dvec3 origin = all.empty() ? dvec3(0.0) : all.centre();
    const culling::OcclusionTest test(view_->view, origin, view_->width, view_->height, pyramid_);
    std::vector<std::uint8_t> hidden;
    for (const AabbD& box : boxes)
      hidden.push_back(box.empty() || test.occluded(core::round_outwards(box, origin)) ? 1 : 0);
    out_->array(hidden);
  }

  // --- queries

  void in_box(const AabbD& box, bool inside) {
    out_->text("inBox");
    out_->array(numbers_of(std::span(&box, 1)));
    out_->numbers({inside ? 1.0 : 0.0});
    if (inside)
      queries().inside(box, core::kDefaultLayerMask, indices_);
    else
      queries().intersecting(box, core::kDefaultLayerMask, indices_);
    record_rising();
  }
  void around(const dvec3& point, double radius) {
    out_->text("around");
    out_->numbers({point.x, point.y, point.z, radius});
    queries().around(point, radius, core::kDefaultLayerMask, indices_);
    record_rising();
  }
  void along(const core::Ray& ray, std::uint32_t most) {
    out_->text("along");
    out_->numbers({ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z,
                   ray.t_min, ray.t_max, double(most)});
    queries().first_along(ray, most == 0 ? culler_->size() : most, core::kDefaultLayerMask, hits_);
    record_hits();
  }
  void nearest(const dvec3& point, std::uint32_t count) {
    out_->text("nearest");
    out_->numbers({point.x, point.y, point.z, double(count)});
    queries().nearest(point, count, core::kDefaultLayerMask, hits_);
    record_hits();
  }

  const std::vector<AabbD>& boxes() const { return boxes_; }

 private:
  culling::SpatialQueries queries() const { return {culler_->bounds(), culler_->culler().hierarchy()}; }
  void list(const core::VisibleSet& set) {
    indices_.clear();
    set.for_each_slot([&](core::Slot slot) {
      if (!culler_->bounds().vacant(slot)) indices_.push_back(culler_->indices()[slot]);
    });
  }
  void record_added(const char* call, const std::vector<AabbD>& boxes, std::uint32_t added, std::uint32_t most) {
    out_->text(call);
    out_->array(numbers_of(boxes));
    out_->numbers({double(most), double(added)});
  }
  void record_rising() {
    for (std::uint32_t& slot : indices_) slot = culler_->indices()[slot];
    std::sort(indices_.begin(), indices_.end());
    out_->array(indices_);
  }
  void record_hits() {
    std::vector<double> distances;
    indices_.clear();
    for (const culling::SlotDistance& hit : hits_) {
      indices_.push_back(culler_->indices()[hit.slot]);
      distances.push_back(hit.distance);
    }
    out_->array(indices_);
    out_->array(distances);
  }

  RecordWriter* out_;
  std::vector<AabbD> boxes_;
  std::unique_ptr<culling::BoxCuller> culler_;
  std::optional<wasm::ViewObject> view_;
  culling::OccluderRaster raster_;
  culling::DepthPyramid pyramid_;
  Indices indices_;
  std::vector<culling::SlotDistance> hits_;
};

std::vector<AabbD> in_world(const PairBlock& block) {
  std::vector<AabbD> boxes;
  for (const core::Aabb& box : block.boxes)
    boxes.push_back(box.empty() ? AabbD() : AabbD{dvec3(box.min) + block.origin, dvec3(box.max) + block.origin});
  return boxes;
}

std::vector<AabbD> plant_boxes(Random& random, std::size_t count, const dvec3& site, double half) {
  std::vector<AabbD> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const dvec3 low = site + point(random, half);
    boxes.push_back({low, low + half * magnitude(random, 1e-4, 0.1) * dvec3(1.0, uniform(random, 0, 1), 1.0)});
    if (chance(random, 0.02)) boxes.back() = {};
  }
  return boxes;
}

/// All families of views and boxes, after edits, too.
void write_views(Both& both) {
  for (const PairFamily& family : kPairFamilies) {
    for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(40)); ++seed) {
      Random random(seed);
      const PairBlock block = family.make(random);
      both.begin(family.name, seed);
      both.create(in_world(block));
      for (const core::View& view : block.views) {
        both.look(view, 100, 100, chance(random, 0.5));
        both.visible();
        both.visible_in();
      }
      Indices some;
      std::vector<AabbD> others;
      for (int i = 0; i < 200; ++i) {
        some.push_back(std::uint32_t(whole(random, 0, int(both.boxes().size()) - 1)));
        others.push_back(both.boxes()[std::size_t(whole(random, 0, int(both.boxes().size()) - 1))]);
      }
      both.update(some, others);
      both.visible();
      std::vector<AabbD> moved = both.boxes();
      std::reverse(moved.begin(), moved.end());
      both.refit(moved);
      both.visible();
    }
  }
}

/// Many boxes: what several threads share.
void write_crowds(Both& both) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Random random(seed);
    const double half = 200.0;
    const dvec3 site = seed % 2 ? dvec3(0.0) : point(random, 1e7);
    both.begin("crowd", seed);
    both.create(plant_boxes(random, 60'000, site, half));
    for (int i = 0; i < 5; ++i) {
      const core::View view = random_view(random, site, half);
      both.look(view, 320, 200);
      both.visible();
      both.build_from(std::vector<float>(320 * 200, float(half * uniform(random, 0.1, 1.0))));
      both.visible_within(true, 0.0f);
      both.visible_within(true, 4.0f);
      both.visible_within(false, 20.0f);
    }
    both.refit(plant_boxes(random, 60'000, site, 2.0 * half));
    both.visible();
  }
}

void add_occluders(Random& random, Both& both, const dvec3& site, double half) {
  std::vector<AabbD> solids = plant_boxes(random, 50, site, half);
  for (AabbD& box : solids)
    if (!box.empty()) box.max += 0.2 * half * uniform(random, 0.0, 1.0);
  both.add_boxes(solids);
  both.add_largest(plant_boxes(random, 500, site, half), 64);
  for (int i = 0; i < 20; ++i) {
    core::Affine placement;
    for (int axis = 0; axis < 3; ++axis) placement.linear[axis] = point(random, 0.15 * half);
    placement.origin = site + point(random, half);
    both.add_placed(placement, i % 2 ? whole(random, 3, 16) : 0);
  }
  std::vector<core::vec3> positions;
  Indices corners;
  for (int i = 0; i < 60; ++i) {
    positions.emplace_back(point(random, 0.5 * half));
    corners.push_back(std::uint32_t(whole(random, 0, i)));
  }
  both.add_mesh(positions, corners, site);
}

void write_occlusion(Both& both) {
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(200)); ++seed) {
    Random random(seed);
    const double half = magnitude(random, 1.0, 1e3);
    const dvec3 site = random_origin(random);
    both.begin("occlusion", seed);
    both.create(plant_boxes(random, 3000, site, half));
    for (int i = 0; i < 3; ++i) {
      core::View view = any_view(random, site, half);
      if (chance(random, 0.3)) add_sections(random, site, half, view);
      both.look(view, whole(random, 1, 300), whole(random, 1, 200), chance(random, 0.3));
      both.begin_raster();
      add_occluders(random, both, site, half);
      both.build();
      both.visible_within(true, 0.0f);
      both.visible_within(true, float(magnitude(random, 1e-2, 1e3)));
      both.visible_within(false, float(magnitude(random, 1e-2, 1e3)));
      both.hides(plant_boxes(random, 200, site, half));
    }
    both.look(random_view(random, site, half), 40, 30);
    std::vector<float> image(40 * 30);
    for (float& distance : image) distance = float(half * magnitude(random, 1e-2, 1.0));
    image[7] = std::numeric_limits<float>::infinity();
    image[8] = std::numeric_limits<float>::quiet_NaN();
    both.build_from(image);
    both.visible_within(true, 0.0f);
  }
}

void write_queries(Both& both) {
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(200)); ++seed) {
    Random random(seed);
    const double half = magnitude(random, 1.0, 1e3);
    const dvec3 site = random_origin(random);
    both.begin("queries", seed);
    both.create(plant_boxes(random, 3000, site, half));
    for (int i = 0; i < 10; ++i) {
      const dvec3 at = site + point(random, half);
      const AabbD range{at, at + magnitude(random, 1e-3, 1.0) * half};
      both.in_box(range, false);
      both.in_box(range, true);
      both.around(at, half * magnitude(random, 1e-3, 1.0));
      core::Ray ray{.origin = site + point(random, 2.0 * half), .direction = {}, .t_min = 0.0, .t_max = infinity};
      ray.direction = at - ray.origin;
      if (chance(random, 0.2)) ray.direction[whole(random, 0, 2)] = 0.0;
      if (chance(random, 0.3)) ray.t_max = uniform(random, 0.0, 1.0);
      both.along(ray, 0);
      both.along(ray, std::uint32_t(whole(random, 1, 5)));
      both.nearest(at, std::uint32_t(whole(random, 0, 20)));
    }
    both.in_box({dvec3(-infinity), dvec3(infinity)}, true);
    both.in_box({}, false);
    both.around(site, -1.0);
    both.around(dvec3(nan), 1.0);
    both.nearest(site, 100'000);
  }
}

/// Boxes that are refused, with words that both sides must find.
void write_refusals(Both& both) {
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  both.begin("refusals", 0);
  const AabbD good{dvec3(0.0), dvec3(1.0)};
  std::vector<AabbD> boxes(20'000, good);
  both.create(boxes);
  both.look(*core::View::perspective({{0, -5, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1), 10, 10);
  for (const AabbD& bad : {AabbD{dvec3(nan), dvec3(1.0)}, AabbD{dvec3(-infinity), dvec3(infinity)},
                           AabbD{dvec3(0.0), dvec3(1.0, 1.0, infinity)}}) {
    std::vector<AabbD> others(20'000, AabbD{dvec3(0.0, -20.0, 0.0), dvec3(1.0, -19.0, 1.0)});
    others[9000] = bad;
    both.refit(others);
    both.visible();
    both.update({3, 5}, {others[0], bad});
    both.visible();
    both.create(others);  // refused: the former one stays
    both.visible();
  }
  both.create({});
  both.visible();
}

}  // namespace

bool write_box_answers(const std::filesystem::path& file) {
  RecordWriter out(file);
  Both both(out);
  write_views(both);
  write_crowds(both);
  write_occlusion(both);
  write_queries(both);
  write_refusals(both);
  return out.close();
}

}  // namespace sightline::tests
